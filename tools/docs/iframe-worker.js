/* SPDX-License-Identifier: Apache-2.0 */
/* Browsers start no worker from a file. The search of pages that are opened as files runs in a hidden frame instead. */
if (location.protocol === "file:") {
    window.Worker = class extends EventTarget {
        constructor(url) {
            super();
            const frame = document.createElement("iframe");
            frame.hidden = true;
            document.body.append(frame);
            const inside = frame.contentWindow;
            inside.document.open();
            inside.document.write("<!DOCTYPE html><body>");
            inside.document.close();
            // The script answers by this.
            inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
            const script = inside.document.createElement("script");
            script.src = url;
            this.loaded = new Promise((done) => { script.onload = done; });
            inside.document.body.append(script);
            this.frame = frame;
        }

        postMessage(data) {
            const send = () => this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }));
            this.loaded.then(send);
        }

        terminate() {
            this.frame.remove();
        }
    };
}
