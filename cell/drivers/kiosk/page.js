// Shows the pictures that the server names and says what is on the screen.
"use strict";
(() => {
  const stage = document.getElementById("stage");
  const waiting = document.getElementById("waiting");
  const LEAST_WAIT_MS = 250;
  const MOST_WAIT_MS = 2000;
  const LOOK_MS = 250;
  let socket = null;
  let wait = LEAST_WAIT_MS;
  let wanted = null;
  let told = "";

  const view = () => ({
    window_px: [window.innerWidth, window.innerHeight],
    pixel_ratio: window.devicePixelRatio,
    screen_px: [window.screen.width, window.screen.height],
    is_visible: document.visibilityState === "visible",
    is_fullscreen: document.fullscreenElement !== null,
    browser: navigator.userAgent.slice(0, 400),
  });

  const say = (message) => {
    if (socket !== null && socket.readyState === WebSocket.OPEN) {
      socket.send(JSON.stringify(message));
    }
  };

  const sayView = () => {
    const now = view();
    told = JSON.stringify(now);
    say({ kind: "view", view: now });
  };

  // Not every change has an event everywhere: zoom, another screen, the desktop's scaling.
  const lookAtView = () => {
    if (JSON.stringify(view()) !== told) sayView();
  };

  const nextFrame = () => new Promise((resolve) => requestAnimationFrame(resolve));

  const sha256 = async (bytes) => {
    if (!window.crypto || !window.crypto.subtle) {
      throw new Error("the browser computes no SHA-256 here; open the page by 127.0.0.1 or https");
    }
    const digest = new Uint8Array(await window.crypto.subtle.digest("SHA-256", bytes));
    return Array.from(digest, (byte) => byte.toString(16).padStart(2, "0")).join("");
  };

  const load = async (show) => {
    const answer = await fetch(show.path);
    if (!answer.ok) {
      throw new Error(`the server answered ${answer.status} to ${show.path}`);
    }
    const bytes = await answer.arrayBuffer();
    const hash = await sha256(bytes);
    const image = new Image();
    image.src = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
    try {
      await image.decode();
    } finally {
      URL.revokeObjectURL(image.src);
    }
    image.alt = show.name;
    image.style.width = `${show.width_px}px`;
    image.style.height = `${show.height_px}px`;
    return { image, hash };
  };

  const put = async (show) => {
    const arrived = performance.now();
    wanted = show;
    say({ kind: "loading", number: show.number });
    try {
      const { image, hash } = await load(show);
      if (wanted !== show) return;
      stage.replaceChildren(image);
      waiting.hidden = true;
      document.title = `Television: ${show.name}`;
      // The first frame callback runs before the frame that holds the picture is drawn, the
      // second one after it.
      await nextFrame();
      await nextFrame();
      if (wanted !== show) return;
      const now = performance.now();
      say({
        kind: "painted",
        number: show.number,
        sha256: hash,
        picture_px: [image.naturalWidth, image.naturalHeight],
        painted_unix_ms: performance.timeOrigin + now,
        took_ms: now - arrived,
        view: view(),
      });
    } catch (error) {
      if (wanted === show) {
        say({ kind: "failed", number: show.number, problem: String(error.message || error).slice(0, 400) });
      }
    }
  };

  const connect = () => {
    socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/socket`);
    socket.onopen = () => {
      wait = LEAST_WAIT_MS;
      sayView();
    };
    socket.onmessage = (event) => {
      const message = JSON.parse(event.data);
      if (message.kind === "show") put(message);
    };
    // The picture stays when the server goes: an experiment must not see a change.
    socket.onclose = () => {
      setTimeout(connect, wait);
      wait = Math.min(2 * wait, MOST_WAIT_MS);
    };
  };

  const stayAwake = () => {
    if (navigator.wakeLock && document.visibilityState === "visible") {
      navigator.wakeLock.request("screen").catch(() => {});
    }
  };

  window.addEventListener("resize", sayView);
  document.addEventListener("fullscreenchange", sayView);
  document.addEventListener("visibilitychange", () => { sayView(); stayAwake(); });
  document.addEventListener("contextmenu", (event) => event.preventDefault());
  document.addEventListener("click", () => {
    if (document.fullscreenElement === null) {
      document.documentElement.requestFullscreen({ navigationUI: "hide" }).catch(() => {});
    }
  });
  setInterval(lookAtView, LOOK_MS);
  stayAwake();
  connect();
})();
