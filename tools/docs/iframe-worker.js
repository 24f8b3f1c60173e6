/* SPDX-License-Identifier: Apache-2.0 */
/* Browsers start no worker from a file: the search then runs in a hidden frame. */
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
            const message = (data) => new MessageEvent("message", { data });
            inside.postMessage = (data) => this.dispatchEvent(message(data));
            const script = inside.document.createElement("script");
            script.src = url;
            this.loaded = new Promise((done) => { script.onload = done; });
            inside.document.body.append(script);
            this.frame = frame;
        }

        postMessage(data) {
            const message = new MessageEvent("message", { data });
            this.loaded.then(() => this.frame.contentWindow.dispatchEvent(message));
        }

        terminate() {
            this.frame.remove();
        }
    };
}
