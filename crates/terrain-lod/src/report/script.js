// Makes the page easier to use; everything can be read without it.
"use strict";
(() => {
  const root = document.documentElement;
  addEventListener("error", (event) => { root.dataset.error = event.message; });
  const byId = (id) => document.getElementById(id);
  const element = (name, className, text) => {
    const made = document.createElement(name);
    made.className = className;
    made.textContent = text;
    return made;
  };

  // The legends: all and none.
  const boxes = {};
  for (const keys of document.querySelectorAll(".keys")) {
    const own = [...keys.querySelectorAll("input")];
    for (const box of own) { boxes[box.id.slice("run".length)] = box; }
    const addButton = (text, checked) => {
      const button = element("button", "", text);
      button.type = "button";
      button.addEventListener("click", () => own.forEach((box) => { box.checked = checked; }));
      keys.append(button);
    };
    addButton("all", true);
    addButton("none", false);
  }
  const swatchOf = (run) => boxes[run].parentElement.querySelector("svg").cloneNode(true);
  const labelOf = (run) => boxes[run].parentElement.querySelector("span").textContent;

  // The cursor: the same frame in all charts of a bench. Numbers as in the tables.
  const format = (number) => {
    if (number === null || number === undefined) { return "\u2013"; }
    const [whole, fraction] = String(number).split(".");
    return whole.replace(/\B(?=(\d{3})+$)/g, "\u202f") + (fraction ? "." + fraction : "");
  };
  const follow = ({ frames, width, charts }) => {
    const curves = Object.entries(charts).map(([id, runs]) => {
      const chart = document.querySelector(`[data-curve="${id}"]`);
      const [left, right, bottom, top] = chart.dataset.ends.split(" ").map(Number);
      const line = chart.appendChild(document.createElementNS(chart.namespaceURI, "path"));
      line.setAttribute("class", "cursor");
      const readout = element("div", "values", "");
      const at = readout.appendChild(element("span", "at", ""));
      const cells = Object.entries(runs).map(([run, values]) => {
        const cell = element("span", "r" + run, "");
        const value = element("b", "", "");
        cell.append(swatchOf(run), element("span", "who", labelOf(run)), value);
        readout.append(cell);
        return { value, values };
      });
      chart.after(readout);
      return { chart, left, right, bottom, top, line, at, cells };
    });
    const last = Math.max(frames[frames.length - 1], 1);
    let shown = 0;
    const show = (point) => {
      shown = Math.min(Math.max(point, 0), frames.length - 1);
      const frame = frames[shown];
      const text = width > 1 ? `frames ${format(frame)} to ${format(frame + width - 1)}` : `frame ${format(frame)}`;
      for (const { left, right, bottom, top, line, at, cells } of curves) {
        const x = left + (right - left) * frame / last;
        line.setAttribute("d", `M${x} ${top}V${bottom}`);
        at.textContent = text;
        for (const { value, values } of cells) { value.textContent = format(values[shown]); }
      }
    };
    for (const { chart, left, right } of curves) {
      chart.addEventListener("pointermove", (event) => {
        const box = chart.getBoundingClientRect();
        const x = (event.clientX - box.left) / box.width * chart.viewBox.baseVal.width;
        show(Math.round((x - left) / (right - left) * last / width));
      });
      chart.addEventListener("keydown", (event) => {
        const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        if (step) { show(shown + step); event.preventDefault(); }
      });
    }
    if (curves.length > 0) { show(Math.floor(frames.length / 2)); }
  };
  JSON.parse(byId("curve-values").textContent).forEach(follow);

  // Two pictures of the same moment, one above the other, cut by the slider.
  const compare = (album) => {
    const groups = [...album.querySelectorAll(".shots")];
    const images = [...album.querySelectorAll(".shots img")];
    if (images.length === 0) { return; }
    const part = (name) => album.querySelector("." + name);
    const [kind, a, b] = ["shot-kind", "shot-a", "shot-b"].map(part);
    const [stage, slider] = ["stage", "slider"].map(part);
    const addOptions = (select, texts) => texts.forEach(([value, text]) => select.append(new Option(text, value)));
    const runs = [...new Set(images.map((image) => Number(image.dataset.run)))];
    runs.sort((one, other) => one - other);
    addOptions(kind, groups.map((group, i) => [i, group.dataset.kind]));
    [a, b].forEach((select) => addOptions(select, runs.map((run) => [run, labelOf(run)])));
    b.selectedIndex = runs.length - 1;
    const cut = (percent) => {
      slider.value = percent;
      stage.style.setProperty("--cut", percent + "%");
    };
    const place = (name, side, select) => {
      const found = groups[kind.value].querySelector(`img[data-run="${select.value}"]`);
      const image = part("image-" + name);
      image.hidden = !found;
      image.src = found ? found.src : "";
      image.alt = found ? found.alt : "";
      part("tag." + side).textContent = name.toUpperCase() + ": " + select.selectedOptions[0].textContent;
    };
    const update = () => { place("a", "left", a); place("b", "right", b); };
    [kind, a, b].forEach((select) => select.addEventListener("change", update));
    slider.addEventListener("input", () => cut(slider.value));
    stage.addEventListener("pointermove", (event) => {
      if (event.buttons === 0) { return; }
      const box = stage.getBoundingClientRect();
      cut(Math.min(Math.max((event.clientX - box.left) / box.width * 100, 0), 100));
    });
    stage.addEventListener("dragstart", (event) => event.preventDefault());
    const flip = () => cut(Number(slider.value) < 50 ? 100 : 0);
    part("flip").addEventListener("click", flip);
    addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select, button, summary, a")) { return; }
      const box = stage.getBoundingClientRect();
      if (box.bottom < 0 || box.top > innerHeight) { return; }
      if (event.key === "a") { cut(100); }
      if (event.key === "b") { cut(0); }
      if (event.key === " ") { flip(); event.preventDefault(); }
    });
    part("compare").hidden = false;
    part("all-shots").open = false;
    update();
    cut(50);
  };
  document.querySelectorAll(".album").forEach(compare);

  // On paper nothing can be unfolded.
  addEventListener("beforeprint", () => {
    document.querySelectorAll("section details").forEach((details) => { details.open = true; });
  });
  root.dataset.script = "ready";
})();
