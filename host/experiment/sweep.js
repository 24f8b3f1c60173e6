/* What a sweep's page does beyond its links: a panel with a set's numbers, picture and command. */
(() => {
'use strict';
const table = document.getElementById('sets');
const heads = [...table.tHead.rows[0].cells].map(cell => cell.textContent);
const panel = document.body.appendChild(document.createElement('div'));
let pinned = false;
panel.className = 'panel';
panel.hidden = true;
panel.setAttribute('role', 'status');

const rowOf = event => {
  const link = event.target.closest && event.target.closest('a[href^="#s"]');
  return link && document.getElementById(link.getAttribute('href').slice(1));
};

const place = link => {
  const at = link.getBoundingClientRect(), box = panel.getBoundingClientRect();
  const right = at.right + 12 + box.width < innerWidth;
  const left = right ? at.right + 12 : at.left - 12 - box.width;
  panel.style.left = Math.max(4, Math.min(left, innerWidth - box.width - 4)) + 'px';
  panel.style.top = Math.max(4, Math.min(at.top - 8, innerHeight - box.height - 4)) + 'px';
};

const show = (row, link) => {
  const numbers = document.createElement('table');
  [...row.cells].forEach((cell, i) => {
    const line = numbers.insertRow();
    line.insertCell().textContent = heads[i];
    line.insertCell().textContent = cell.textContent;
  });
  const more = [...row.nextElementSibling.cells[0].childNodes].map(node => node.cloneNode(true));
  panel.replaceChildren(numbers, ...more);
  if (pinned && navigator.clipboard) {
    const copy = panel.appendChild(document.createElement('button'));
    copy.textContent = 'Copy the command';
    copy.onclick = () => navigator.clipboard.writeText(panel.querySelector('pre').textContent);
  }
  panel.hidden = false;
  place(link);
};

const hide = () => {
  pinned = false;
  panel.hidden = true;
};

const point = event => {
  const row = !pinned && rowOf(event);
  if (row) show(row, event.target.closest('a'));
};
for (const kind of ['mouseover', 'focusin']) document.addEventListener(kind, point);
for (const kind of ['mouseout', 'focusout'])
  document.addEventListener(kind, event => !pinned && rowOf(event) && hide());
document.addEventListener('click', event => {
  const row = rowOf(event);
  if (row) {
    event.preventDefault();
    pinned = true;
    show(row, event.target.closest('a'));
  } else if (!panel.contains(event.target)) hide();
});
document.addEventListener('keydown', event => event.key === 'Escape' && hide());

const body = table.tBodies[0];
const numberOf = (row, column) => {
  const number = parseFloat(row.cells[column] ? row.cells[column].textContent : '');
  return Number.isNaN(number) ? Infinity : number;
};
[...table.tHead.rows[0].cells].forEach((head, column) => {
  let sign = -1;
  head.addEventListener('click', () => {
    sign = -sign;
    const rows = [...body.rows].filter(row => row.id);
    const pairs = rows.map(row => [row, row.nextElementSibling]);
    pairs.sort((a, b) => sign * (numberOf(a[0], column) - numberOf(b[0], column)) || 0);
    body.append(...pairs.flat());
  });
});
})();
