// Browsers start no worker for a page opened from a file. The search then runs in a hidden frame instead, with the
// part of a worker's interface that Material for MkDocs uses. It finds the frame's page by the name IFrameWorker.
window.IFrameWorker = class extends EventTarget {
  constructor(url) {
    super();
    const frame = document.createElement("iframe");
    frame.hidden = true;
    document.body.append(frame);
    const inner = frame.contentWindow;
    this.inner = inner;
    inner.document.open();
    inner.document.write("<body></body>");
    inner.document.close();
    inner.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
    inner.importScripts = async (...sources) => {
      for (const source of sources) await this.run(source);
    };
    this.ready = this.run(url);
  }

  run(source) {
    const script = this.inner.document.createElement("script");
    script.src = source;
    const loaded = new Promise((resolve) => script.addEventListener("load", resolve));
    this.inner.document.body.append(script);
    return loaded;
  }

  postMessage(data) {
    this.ready.then(() => this.inner.dispatchEvent(new MessageEvent("message", { data })));
  }
};
if (location.protocol === "file:") window.Worker = window.IFrameWorker;
