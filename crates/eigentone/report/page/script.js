"use strict";
// Reads plots back from their drawings: values under the pointer, zoom, curves on and off; sorts and copies tables.
(() => {
  const GRID = 1e5, LEAST = GRID / 2000;
  const minus = text => text.replaceAll("-", "−");
  const SUPER = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const raised = power => (power < 0 ? "⁻" : "") + [...String(Math.abs(power))].map(d => SUPER[d]).join("");
  const scaled = (value, power) => {
    const [digits, own] = value.toExponential().split("e");
    return Number(digits + "e" + (+own + power));
  };
  const make = (name, parent, text) => {
    const made = document.createElement(name);
    if (text !== undefined) made.textContent = text;
    parent.append(made);
    return made;
  };
  const button = (parent, text, label, run) => {
    const made = make("button", parent, text);
    made.type = "button";
    made.title = label;
    made.setAttribute("aria-label", label);
    made.addEventListener("click", run);
    return made;
  };

  // An axis from 0 to GRID. Places are whole, so that values are known to half a unit of the whole axis.
  function axisOf(text) {
    const [scale, power, low, high, quantity, ...unit] = text.split("|");
    const log = scale === "logarithmic", from = +low, to = +high, span = to - from;
    const digits = Math.floor(-Math.log10(log ? Math.LN10 * span / GRID : scaled(span / GRID, +power)));
    const unitText = unit.join("|");
    return {
      log, quantity, unit: unitText,
      reduced: place => from + place / GRID * span,
      place: value => (value - from) / span * GRID,
      show(place) {
        const at = this.reduced(place);
        let text;
        if (log) {
          const power = Math.floor(at), lead = 10 ** (at - power);
          text = power < -3 || power > 4 ? lead.toFixed(Math.max(digits, 0)) + "e" + power : (10 ** at).toPrecision(Math.max(digits, 0) + 1);
        } else {
          const value = scaled(at, +power);
          const size = value === 0 ? 0 : Math.floor(Math.log10(Math.abs(value)));
          if (digits >= 0 && digits <= 8) text = value.toFixed(digits);
          else text = size < -digits ? "0" : value.toExponential(Math.min(size + digits, 15));
        }
        return minus(text) + (unitText ? " " + unitText : "");
      },
    };
  }

  // Divisions of a part of an axis: places and labels.
  function ticks(axis, start, size, most) {
    const low = axis.reduced(start), high = axis.reduced(start + size), found = [];
    if (axis.log && high - low > 1) {
      const each = Math.ceil((high - low) / most);
      for (let k = Math.ceil(low); k <= high; k++) if (k % each === 0) found.push([k, "10" + raised(k)]);
    } else {
      // Equal steps of the value; on a logarithmic axis of less than a decade they lie apart enough.
      const [from, to] = axis.log ? [10 ** low, 10 ** high] : [low, high];
      const rough = (to - from) / most, power = 10 ** Math.floor(Math.log10(rough));
      const step = [1, 2, 5, 10].map(factor => factor * power).find(step => step >= rough * (1 - 1e-12));
      const decimals = Math.max(0, -Math.floor(Math.log10(step)));
      for (let k = Math.ceil(from / step); k <= Math.floor(to / step); k++) {
        const value = k * step, far = decimals > 6 || Math.abs(to) >= 1e6;
        found.push([axis.log ? Math.log10(value) : value, minus(far ? value.toPrecision(6).replace(/\.?0+(?=e|$)/, "") : value.toFixed(decimals)), k === 0]);
      }
    }
    return found.map(([value, label, zero]) => [axis.place(value), label, zero]);
  }

  function pointsOf(path) {
    const found = [];
    let x = 0, y = 0;
    for (const [, letter, numbers] of path.getAttribute("d").matchAll(/([Mlh])([^Mlh]*)/g)) {
      const values = (numbers.match(/-?\d+/g) || []).map(Number);
      if (letter === "h") continue;
      for (let k = 0; k < values.length; k += 2) {
        x = values[k] + (letter === "l" ? x : 0);
        y = values[k + 1] + (letter === "l" ? y : 0);
        found.push([x, y]);
      }
    }
    return found;
  }

  function plot(figure) {
    const areas = [...figure.querySelectorAll("svg.area")];
    if (areas.length === 0) return;
    figure.classList.add("live");
    const x = axisOf(areas[0].dataset.x), y = axisOf(areas[0].dataset.y);
    const names = [...figure.querySelectorAll(".name")].map(name => name.textContent);
    const box = Object.fromEntries(["x", "y", "width", "height"].map(key => [key, +areas[0].getAttribute(key)]));
    const drawn = areas.map(area => ({
      area, svg: area.parentNode, axes: area.parentNode.querySelector(".axes"), before: null,
      curves: [...area.querySelectorAll("[data-i]")].map(path => ({ path, index: +path.dataset.i, all: null })),
    }));
    const points = curve => curve.all || (curve.all = pointsOf(curve.path));
    const shown = curve => !curve.path.classList.contains("off");
    let view = [0, 0, GRID, GRID], at = null;

    const tools = document.createElement("div");
    tools.className = "tools";
    tools.setAttribute("role", "group");
    tools.setAttribute("aria-label", "View of " + figure.querySelector("h3").textContent);
    figure.querySelector("h3").after(tools);
    const middle = () => at ? at.point[0] : view[0] + view[2] / 2;
    button(tools, "+", "Zoom in", () => zoom(0.5, middle()));
    button(tools, "−", "Zoom out", () => zoom(2, middle()));
    button(tools, "←", "Move the view to the left", () => pan(-0.5));
    button(tools, "→", "Move the view to the right", () => pan(0.5));
    button(tools, "all", "Show all", () => look(0, GRID));
    const said = document.createElement("output");
    (figure.querySelector(".panels") || figure.querySelector(":scope > svg")).after(said);

    function look(start, size) {
      size = Math.min(Math.max(size, LEAST), GRID);
      start = Math.min(Math.max(start, 0), GRID - size);
      view = [start, 0, size, GRID];
      if (size < GRID) {
        // As high as what is seen of the curves.
        let low = Infinity, high = -Infinity;
        for (const one of drawn) for (const curve of one.curves.filter(shown)) {
          const all = points(curve);
          all.forEach(([px, py], k) => {
            // Lines that only pass through have their ends outside.
            const next = all[Math.min(k + 1, all.length - 1)][0], last = all[Math.max(k - 1, 0)][0];
            if (next >= start && last <= start + size) [low, high] = [Math.min(low, py), Math.max(high, py)];
          });
        }
        if (low <= high) {
          const room = Math.max(0.06 * (high - low), LEAST / 2);
          [view[1], view[3]] = [low - room, high - low + 2 * room];
        }
      }
      drawn.forEach(drawAxes);
    }

    function drawAxes(one) {
      one.before ??= one.axes.innerHTML;
      one.area.setAttribute("viewBox", view.join(" "));
      if (view[2] === GRID) return void (one.axes.innerHTML = one.before);
      const right = box.x + box.width, bottom = box.y + box.height;
      const most = Math.min(+one.area.dataset.n, 6);
      const lines = ticks(x, view[0], view[2], most).map(([place, label, zero]) => {
        const px = box.x + (place - view[0]) / view[2] * box.width;
        return `<path class="${zero ? "z" : "g"}" d="M${px} ${box.y}V${bottom}"/><text x="${px}" y="${bottom + 18}" text-anchor="${px > right - 10 ? "end" : "middle"}">${label}</text>`;
      });
      lines.push(...ticks(y, GRID - view[1] - view[3], view[3], most).map(([place, label, zero]) => {
        const py = box.y + (GRID - place - view[1]) / view[3] * box.height;
        return `<path class="${zero ? "z" : "g"}" d="M${box.x} ${py}H${right}"/><text x="${box.x - 6}" y="${py + 4.5}" text-anchor="end">${label}</text>`;
      }));
      one.axes.innerHTML = lines.join("");
    }

    const zoom = (factor, about) => look(about - (about - view[0]) * factor, view[2] * factor);
    const pan = part => look(view[0] + part * view[2], view[2]);

    // Marks a point of a curve, and says it with those of other curves at the same place.
    function mark(next) {
      at = next;
      figure.querySelectorAll(".cross, .point").forEach(old => old.remove());
      said.textContent = "";
      if (!at) return;
      const { one, curve, point: [px, py] } = at;
      for (const [name, d] of [["cross", `M${px} ${view[1]}v${view[3]}M${view[0]} ${py}h${view[2]}`], ["point", `M${px} ${py}h0`]]) {
        const line = document.createElementNS(one.svg.namespaceURI, "path");
        line.setAttribute("class", name);
        line.setAttribute("d", d);
        one.area.append(line);
      }
      const value = (curve, place) => `${names[curve.index]} ${y.show(GRID - place)}`;
      const others = drawn.length > 1 ? [] : one.curves.filter(other => other !== curve && shown(other));
      const same = others.flatMap(other => {
        const found = points(other).find(([x]) => x === px);
        return found ? [value(other, found[1])] : [];
      });
      said.textContent = `${x.quantity} ${x.show(px)}: ${[value(curve, py), ...same].join(" · ")}`;
    }

    // The point nearest in the drawing, where across counts more.
    function nearest(one, gx, gy, curves) {
      let least = Infinity, found = null;
      for (const curve of curves) points(curve).forEach((point, index) => {
        if (point[0] < view[0] || point[0] > view[0] + view[2]) return;
        const far = Math.hypot(3 * (point[0] - gx) / view[2] * box.width, (point[1] - gy) / view[3] * box.height);
        if (far < least) [least, found] = [far, { one, curve, index, point }];
      });
      return found;
    }

    for (const one of drawn) {
      const { svg } = one;
      const placed = event => {
        const outer = svg.getBoundingClientRect(), scale = outer.width / svg.viewBox.baseVal.width;
        return [
          view[0] + ((event.clientX - outer.left) / scale - box.x) / box.width * view[2],
          view[1] + ((event.clientY - outer.top) / scale - box.y) / box.height * view[3],
        ];
      };
      let held = null;
      svg.setAttribute("tabindex", "0");
      svg.addEventListener("pointerdown", event => { held = placed(event)[0]; svg.setPointerCapture(event.pointerId); });
      svg.addEventListener("pointerup", () => { held = null; });
      svg.addEventListener("pointercancel", () => { held = null; });
      svg.addEventListener("pointerleave", () => { if (document.activeElement !== svg) mark(null); });
      svg.addEventListener("pointermove", event => {
        if (held !== null && view[2] < GRID) look(view[0] + held - placed(event)[0], view[2]);
        mark(nearest(one, ...placed(event), one.curves.filter(shown)));
      });
      svg.addEventListener("dblclick", () => look(0, GRID));
      svg.addEventListener("wheel", event => {
        if (!event.ctrlKey) return;
        event.preventDefault();
        zoom(event.deltaY < 0 ? 0.8 : 1.25, placed(event)[0]);
      }, { passive: false });
      svg.addEventListener("blur", () => mark(null));
      svg.addEventListener("keydown", event => {
        if (event.ctrlKey || event.altKey || event.metaKey) return;
        const seen = one.curves.filter(shown);
        const here = at && at.one === one && shown(at.curve) ? at : nearest(one, view[0] + view[2] / 2, view[1] + view[3] / 2, seen);
        const walk = by => {
          if (!here) return;
          const all = points(here.curve), index = Math.min(Math.max(here.index + by, 0), all.length - 1);
          const point = all[index];
          if (point[0] < view[0] || point[0] > view[0] + view[2]) look(point[0] - view[2] / 2, view[2]);
          mark({ ...here, index, point });
        };
        const change = by => {
          if (!here) return;
          const next = seen[(seen.indexOf(here.curve) + by + seen.length) % seen.length];
          mark(nearest(one, here.point[0], here.point[1], [next]) || here);
        };
        const step = event.shiftKey ? 25 : 1;
        const keys = {
          ArrowLeft: () => walk(-step), ArrowRight: () => walk(step), Home: () => walk(-Infinity), End: () => walk(Infinity),
          ArrowUp: () => change(-1), ArrowDown: () => change(1),
          "+": () => zoom(0.5, middle()), "=": () => zoom(0.5, middle()), "-": () => zoom(2, middle()),
          "0": () => look(0, GRID), Escape: () => mark(null),
        };
        if (!keys[event.key]) return;
        event.preventDefault();
        keys[event.key]();
        if (at) mark(at);
      });
    }

    // Where each curve has a panel, the legend has only what acts behind all.
    const entries = [...figure.querySelectorAll(".legend li")], first = names.length - entries.length;
    entries.forEach((entry, place) => {
      const index = first + place;
      const inside = [...entry.childNodes];
      const made = button(entry, "", "Show or hide " + names[index], () => {
        const on = made.getAttribute("aria-pressed") !== "true";
        made.setAttribute("aria-pressed", on);
        figure.querySelectorAll(`[data-i="${index}"], [data-m="${index}"]`).forEach(part => part.classList.toggle("off", !on));
        mark(null);
      });
      made.removeAttribute("aria-label");
      made.append(...inside);
      made.setAttribute("aria-pressed", "true");
    });
  }

  function table(scroll) {
    const all = scroll.querySelector("table"), body = all && all.tBodies[0];
    if (!body) return;
    const headers = [...all.tHead.rows[0].cells], given = [...body.rows];
    const plain = cell => cell.textContent.replaceAll("\u2007", "").replaceAll("−", "-").trim();
    // Without "NaN" for names that begin as numbers do.
    const number = text => /^[-+]?[\d.]+(e[-+]?\d+)?( |$)/i.test(text) ? parseFloat(text) : NaN;
    headers.forEach((header, column) => {
      const text = header.textContent;
      header.textContent = "";
      const made = button(header, text, "Sort by " + text, () => {
        const next = { none: "ascending", ascending: "descending", descending: "none" }[header.ariaSort || "none"];
        headers.forEach(other => { other.ariaSort = null; });
        header.ariaSort = next === "none" ? null : next;
        const sign = next === "descending" ? -1 : 1;
        const order = (a, b) => {
          const [s, t] = [a, b].map(row => plain(row.cells[column])), [p, q] = [number(s), number(t)];
          // What is no number comes last.
          if (isNaN(p) || isNaN(q)) return isNaN(p) && isNaN(q) ? sign * s.localeCompare(t) : isNaN(p) - isNaN(q);
          return sign * (p - q);
        };
        body.append(...(next === "none" ? given : [...given].sort(order)));
      });
      made.removeAttribute("aria-label");
    });
    const tools = document.createElement("div");
    tools.className = "tools";
    scroll.before(tools);
    const copy = button(tools, "Copy table", "Copy the table, columns separated by tabs", async () => {
      const rows = [headers, ...[...body.rows].map(row => [...row.cells])];
      const text = rows.map(row => row.map(plain).join("\t")).join("\n") + "\n";
      copy.dataset.copied = text;
      try {
        await navigator.clipboard.writeText(text);
      } catch {
        const area = make("textarea", tools, text);
        area.select();
        document.execCommand("copy");
        area.remove();
        copy.focus();
      }
      copy.textContent = "Copied";
      setTimeout(() => { copy.textContent = "Copy table"; }, 1500);
    });
    copy.removeAttribute("aria-label");
  }

  document.querySelectorAll("figure.plot").forEach(plot);
  document.querySelectorAll(".scroll").forEach(table);
  const help = document.createElement("p");
  help.className = "soft live-only";
  help.textContent = "Plots: point at a curve or use the arrow keys to read values, to the digits shown; zoom with + − 0 or with Ctrl and the wheel; drag to pan; press a name in the legend to hide or show its curve. Tables: press a header to sort.";
  document.querySelector("header").append(help);
})();
