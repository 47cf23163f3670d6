// What a page does: copies commands; draws traces; moves the bench with the time that all traces share.
(() => {
'use strict';
const $ = (of, what) => [...of.querySelectorAll(what)];
const css = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
const make = (tag, set) => Object.assign(document.createElement(tag), set);

$(document, '.copy').forEach(button => button.addEventListener('click', async () => {
  const pre = button.parentElement.querySelector('pre');
  try { await navigator.clipboard.writeText(pre.textContent); } catch {
    const range = document.createRange();
    range.selectNodeContents(pre);
    getSelection().removeAllRanges();
    getSelection().addRange(range);
    document.execCommand('copy');
  }
  button.textContent = 'Copied';
  const said = button.parentElement.querySelector('.said');
  if (said) said.textContent = 'copied';
  setTimeout(() => { button.textContent = 'Copy'; if (said) said.textContent = ''; }, 1500);
}));

// What is wider than its place is scrolled by keys too.
// In the next frame: the hint takes room, and a change of size within the observer's own turn is an error.
const scrolled = new ResizeObserver(of => requestAnimationFrame(() => of.forEach(({target: e}) => {
  const more = e.scrollWidth > e.clientWidth;
  e.classList.toggle('more', more);
  if (more) {
    e.tabIndex = 0;
    e.setAttribute('role', 'group');
    e.setAttribute('aria-label', `${(e.querySelector('caption, h3')?.textContent || 'content').trim()}, scrolled sideways`);
  } else ['tabindex', 'role', 'aria-label'].forEach(name => e.removeAttribute(name));
})));
$(document, '.scroll, .chart, .card').forEach(e => scrolled.observe(e));

// Sixteen-bit codes between the smallest and the largest number; the last code is none.
const unpack = ({a, s, b}) => {
  const bytes = atob(b), out = new Array(bytes.length / 2);
  for (let i = 0; i < out.length; i++) {
    const code = bytes.charCodeAt(2 * i) | bytes.charCodeAt(2 * i + 1) << 8;
    out[i] = code === 65535 ? null : a + s * code;
  }
  return out;
};
// What varies by less of its value to either side is constant to a reader; its axis reaches a twentieth to either side.
const CONSTANT = 1e-5;
const rangeOf = (least, most) => (_, low, high) => {
  if (low == null || high == null) return [0, 1];
  // What is beyond leaves the drawing.
  if (most != null) [low, high] = [Math.min(low, most), Math.min(high, most)];
  const middle = (low + high) / 2, half = Math.max((high - low) * 0.55, least / 2);
  const room = half > CONSTANT * Math.abs(middle) ? half : middle === 0 ? 1 : 0.05 * Math.abs(middle);
  return [middle - room, middle + room];
};
// Numbers beside ticks with as many decimals as their distance needs: no two are alike.
const ticks = (_, splits, axis, space, step) => {
  let digits = 0;
  while (digits < 9 && Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) > 1e-6 * step * 10 ** digits) digits++;
  return splits.map(x => Math.abs(x) < step / 2 ? '0' : x.toFixed(digits));
};
// Of rows, lines are higher where something is up.
const said = (names, x) => !names.length ? shown(x) : x == null ? '–' : x % 1 > 0.3 ? 'up' : 'down';
const shown = x => x == null ? '–' : Math.abs(x) < 5e-4 ? '0' : Math.abs(x) >= 100 ? x.toFixed(0) : Math.abs(x) >= 10 ? x.toFixed(1)
  : Math.abs(x) >= 1 ? x.toFixed(2) : x.toFixed(3);

$(document, '.viewer').forEach((root, number) => {
  const data = JSON.parse(root.querySelector('script').textContent);
  const plots = new Map();
  const figures = $(root, 'figure[data-plot]');
  const bench = root.querySelector('.bench');
  const key = 'viewer' + number;
  let now = 0, at = 0, run = null, moving = false, settling = 0, enlarged = null;

  // Of a run, unpacked once.
  const read = k => {
    const of = data.runs[k];
    if (!of.read) {
      of.read = {
        t: unpack(of.t),
        v: of.v.map(lines => lines.map(line => line && unpack(line))),
        course: of.course && {
          ...of.course,
          parts: of.course.parts.map(([name, p]) => [name, p.map(unpack)]),
          forces: of.course.forces.map(([name, where, p]) => [name, where, p.map(unpack)]),
          grip: unpack(of.course.grip),
        },
      };
    }
    return {...of, ...of.read};
  };

  // Phases, noise band, and forces that are open, behind the lines.
  const shade = index => u => {
    const c = u.ctx, x = t => u.valToPos(t, 'x', true), y = v => u.valToPos(v, 'y', true);
    const {left, top, width, height} = u.bbox;
    c.save();
    c.beginPath(); c.rect(left, top, width, height); c.clip();
    for (const [kind, from, to] of run.spans) {
      if (!kind) continue;
      c.fillStyle = css(kind);
      c.fillRect(x(from), top, x(to) - x(from), height);
    }
    const area = (points, ink, alpha) => {
      if (points.length < 2) return;
      c.globalAlpha = alpha; c.fillStyle = css(ink); c.beginPath();
      points.forEach((p, i) => i ? c.lineTo(x(p[0]), y(p[1])) : c.moveTo(x(p[0]), y(p[1])));
      points.slice().reverse().forEach(p => c.lineTo(x(p[0]), y(p[2])));
      c.closePath(); c.fill(); c.globalAlpha = 1;
    };
    (run.open[index] || []).forEach(points => area(points, 'm2', 0.2));
    (run.half[index] || []).forEach(([line, from, to, half]) => {
      const v = run.v[index][line] || [], points = [];
      v.forEach((m, i) => {
        if (m != null && run.t[i] >= from && run.t[i] <= to) points.push([run.t[i], m - half, m + half]);
      });
      area(points, 'measured', 0.22);
    });
    c.restore();
  };

  const draw = figure => {
    const index = +figure.dataset.plot, of = data.plots[index];
    const host = figure.querySelector('.plot');
    plots.get(figure)?.destroy();
    plots.delete(figure);
    // What is folded is drawn when it is unfolded.
    if (!host.clientWidth) return;
    const lines = run.v[index];
    const known = of.lines.map((line, i) => ({...line, i})).filter(line => lines[line.i]);
    figure.hidden = !known.length;
    if (!known.length) return;
    const axis = {stroke: css('ink'), font: '12px system-ui,sans-serif', ticks: {stroke: css('line'), size: 4}};
    const u = new uPlot({
      width: host.clientWidth, height: +figure.dataset.height || 170,
      cursor: {sync: {key}, y: false, drag: {x: true, y: false}},
      scales: {x: {time: false}, y: {range: of.names.length ? () => [-0.4, of.names.length - 0.2] : rangeOf(of.least || 0, of.most)}},
      axes: [{...axis, grid: {show: false}, size: 26, values: ticks}, {...axis, grid: {stroke: css('grid'), width: 1},
        ...(of.names.length ? {size: 132, splits: () => of.names.map((_, i) => i), values: () => of.names} : {size: 56, values: ticks})}],
      // As the lines themselves: the second finger's are dashed.
      legend: {show: !of.names.length, markers: {dash: (_, i) => known[i - 1]?.dash ? 'dashed' : 'solid'}},
      series: [{label: 't', value: (_, v) => v == null ? '–' : v.toFixed(3) + ' s'}, ...known.map(line => ({
        label: line.label, stroke: css(line.ink), width: line.ink === 'measured' ? 1.3 : 2, spanGaps: true,
        dash: line.dash ? [6, 4] : undefined, points: {show: false}, value: (_, v) => said(of.names, v),
      }))],
      hooks: {drawClear: [shade(index)], setScale: [(u, key) => {
        if (key === 'x') figure.dataset.shown = [u.scales.x.min, u.scales.x.max].map(t => t.toFixed(3)).join(' ');
      }], setCursor: [u => {
        if (moving || settling || u.cursor.idx == null || u.cursor.left < 0) return;
        moment(u.cursor.idx, u);
      }]},
    }, [run.t, ...known.map(line => lines[line.i])], host);
    const ranges = known.map(line => {
      const all = lines[line.i].filter(x => x != null);
      const [least, most] = [Math.min(...all), Math.max(...all)].map(x => said(of.names, x));
      return all.length ? `${line.label} from ${least} to ${most}` : `${line.label} unknown`;
    });
    const canvas = host.querySelector('canvas');
    canvas.setAttribute('role', 'img');
    canvas.dataset.words = `${of.title} over time${of.unit === '1' ? '' : ', ' + of.unit}: ${ranges.join('; ')}`;
    keys(host.querySelector('.u-legend'), u, of.title);
    u.names = of.names;
    touch(u);
    plots.set(figure, u);
    say(figure, u);
    // A plot sets its cursor for the first time after this, wherever that is: it is not what the reader chose.
    settling++;
    setTimeout(() => { if (!--settling) moment(at); });
  };
  // Lines are switched by keys too: one stop of the Tab key for all of a plot, arrows between them. The drawing's words have
  // the values, so they are not read here.
  const keys = (legend, u, title) => {
    if (!legend) return;
    legend.setAttribute('role', 'group');
    legend.setAttribute('aria-label', `lines of ${title}`);
    $(legend, 'tbody, tr').forEach(e => e.setAttribute('role', 'presentation'));
    $(legend, 'tr:first-child, td').forEach(e => e.setAttribute('aria-hidden', 'true'));
    const heads = $(legend, 'tr:not(:first-child) th');
    const show = () => heads.forEach((e, i) => e.setAttribute('aria-pressed', String(u.series[i + 1].show)));
    heads.forEach((e, i) => {
      e.setAttribute('role', 'button');
      e.tabIndex = i ? -1 : 0;
      e.addEventListener('click', () => setTimeout(show));
      e.addEventListener('keydown', event => {
        const by = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key];
        if (by) {
          const next = heads[(i + by + heads.length) % heads.length];
          heads.forEach(h => { h.tabIndex = h === next ? 0 : -1; });
          next.focus();
        } else if (event.key === 'Enter' || event.key === ' ') e.click();
        else return;
        event.preventDefault();
      });
    });
    show();
  };
  // A drawing in words, at the chosen time.
  const here = () => Math.min(at, run.t.length - 1);
  const valuesOf = u => (u?.series.slice(1) || []).map((line, k) => `${line.label} ${said(u.names, u.data[k + 1][here()])}`);
  const say = (figure, u) => {
    const canvas = figure.querySelector('canvas'), time = run.t[here()].toFixed(3);
    canvas.setAttribute('aria-label', `${canvas.dataset.words}. At ${time} s: ${valuesOf(u).join(', ')}`);
  };
  // While plots of two trials share a cursor, it is nobody's.
  const drawAll = () => { moving = true; figures.forEach(draw); moving = false; };

  // All plots and the bench at one time. `from` has its cursor there already.
  const moment = (i, from) => {
    at = Math.min(i, run.t.length - 1);
    if (slider) slider.value = at;
    moving = true;
    if (!from) plots.forEach(u => u.setCursor({left: u.valToPos(run.t[at], 'x'), top: 10}, false, false));
    moving = false;
    plots.forEach((u, figure) => say(figure, u));
    const seen = move() || valuesOf([...plots.values()][0]);
    slider?.setAttribute('aria-valuetext', [`t = ${run.t[at].toFixed(3)} s`, ...seen].join(', '));
  };

  const arrow = ([x, y], [dx, dy]) => {
    const length = Math.hypot(dx, dy);
    if (!(length > 4)) return 'M0 0';
    const ux = dx / length, uy = dy / length, tx = x + dx, ty = y + dy;
    return `M${x} ${y}L${tx} ${ty}M${tx - 8 * ux - 5 * uy} ${ty - 8 * uy + 5 * ux}L${tx} ${ty}` +
      `L${tx - 8 * ux + 5 * uy} ${ty - 8 * uy - 5 * ux}`;
  };
  // What is on the bench at this time, in words; nothing where there is none.
  const move = () => {
    const c = run.course, svg = bench?.querySelector('svg');
    if (!c || !svg) return null;
    const k = enlarged ?? c.k, place = {};
    const px = (x, y) => [c.centre[0] + x * c.mm, c.centre[1] - y * c.mm];
    const truth = c.parts[0][1].map(q => q[at] ?? 0);
    for (const [name, p] of c.parts) {
      const here = p.map(q => q[at] ?? 0);
      const [x, y, a] = name === 'pusher' ? here : here.map((q, j) => truth[j] + k * (q - truth[j]));
      place[name] = px(x, y);
      svg.querySelector(`[data-part="${name}"]`)?.setAttribute('transform',
        `translate(${place[name].map(q => q.toFixed(2)).join(' ')}) rotate(${(-a).toFixed(3)})`);
    }
    place.fingers = px(...c.fingers);
    const [, , w, h] = svg.getAttribute('viewBox').split(' ').map(Number);
    const placed = [], words = [], room = [122, 18];
    c.forces.forEach(([name, where, [fx, fy]]) => {
      const force = [fx[at] ?? 0, fy[at] ?? 0], d = [force[0] * c.n, -force[1] * c.n];
      const from = place[where] || [0, 0];
      svg.querySelector(`[data-force="${name}"]`)?.setAttribute('d', arrow(from, d));
      const [what, ink] = name.split(' ');
      const label = ink === 'measured' && svg.querySelector(`[data-label="${what}"]`);
      if (label) {
        // Beyond the tip: on along an arrow that lies, above or below one that stands.
        const lies = Math.abs(d[0]) >= Math.abs(d[1]), ends = lies && d[0] < 0;
        const tip = from[0] + d[0] + (ends ? -6 : 6);
        const x = ends ? Math.min(Math.max(tip, room[0]), w) : Math.min(Math.max(tip, 5), w - room[0]);
        const left = ends ? x - room[0] : x, shift = lies ? 4 : 4 + 10 * Math.sign(d[1]);
        let y = Math.min(Math.max(from[1] + d[1] + shift, 52), h - 36), over;
        // No text over another; one below another is a height from it but for rounding.
        while ((over = placed.find(p => Math.abs(left - p[0]) < room[0] && Math.abs(y - p[1]) < room[1] - 1e-6))) y = over[1] + room[1];
        placed.push([left, y]);
        label.setAttribute('x', x);
        label.setAttribute('y', y);
        label.setAttribute('text-anchor', ends ? 'end' : 'start');
        label.textContent = `${what} ${Math.hypot(...force).toFixed(1)} N`;
        words.push(label.textContent);
      }
    });
    const note = (name, text) => { const e = svg.querySelector(`[data-note="${name}"]`); if (e) e.textContent = text; };
    note('time', `t = ${run.t[at].toFixed(3)} s`);
    note('enlarged', k > 1 ? `deviation of the model's object drawn ${k} times larger` : 'to scale');
    if (c.grip[at] != null) note('grip', `grip ${c.grip[at].toFixed(1)} N`);
    // The drawing in words, at this time.
    if (c.grip[at] != null) words.push(`grip ${c.grip[at].toFixed(1)} N`);
    for (const [name, p] of c.parts.slice(1)) {
      if (name === 'pusher') continue;
      const [x, y, a] = p.map((q, j) => (q[at] ?? 0) - truth[j]);
      const line = data.plots.flatMap(plot => plot.lines).find(line => line.ink === name);
      const model = line ? line.label.split(', ')[0] : name;
      words.push(`object by ${model} off by ${Math.hypot(x, y).toFixed(2)} mm and ${Math.abs(a).toFixed(2)} degrees`);
    }
    svg.dataset.words ??= svg.getAttribute('aria-label');
    svg.setAttribute('aria-label', `${svg.dataset.words}: t = ${run.t[at].toFixed(3)} s, ${words.join(', ')}`);
    return words;
  };

  const choose = k => {
    now = k;
    run = read(k);
    $(root, 'button[data-run]').forEach(b => b.setAttribute('aria-pressed', String(+b.dataset.run === k)));
    // What is written anew is spoken, at loading before the title.
    $(root, '.chosen').filter(e => e.textContent !== run.said).forEach(e => { e.textContent = run.said; });
    if (bench) bench.innerHTML = run.svg || '';
    if (slider) slider.max = run.t.length - 1;
    phases?.replaceChildren(make('option', {value: '', textContent: 'whole'}),
      ...run.spans.map((s, i) => make('option', {value: i, textContent: s[3]})));
    drawAll();
    moment(run.course ? run.course.start : Math.floor(run.t.length / 2));
  };

  // All plots from the beginning to the end of a phase; of none: of the trial.
  const zoom = span => {
    const [first, last] = [run.t[0], run.t[run.t.length - 1]];
    const room = span ? 0.15 * (span[2] - span[1]) + 0.02 : 0;
    const [min, max] = span ? [Math.max(span[1] - room, first), Math.min(span[2] + room, last)] : [first, last];
    if (max > min) stretch(min, max);
    if (phases) phases.value = span ? run.spans.indexOf(span) : '';
  };

  // All plots have one time axis: from `min` to `max`, within the trial.
  const stretch = (min, max) => {
    const [first, last] = [run.t[0], run.t[run.t.length - 1]];
    const wide = Math.min(Math.max(max - min, (last - first) / 500), last - first);
    const from = Math.min(Math.max(min, first), last - wide);
    plots.forEach(u => u.setScale('x', {min: from, max: from + wide}));
  };
  // Fingers on a plot: two zoom, one moves what is zoomed, or the time where all is shown; two taps show all. Up and down the page
  // scrolls.
  const touch = u => {
    const on = new Map();
    let began = null, tapped = 0;
    const timeAt = x => {
      const {left, width} = u.over.getBoundingClientRect(), {min, max} = began || u.scales.x;
      return min + (max - min) * (x - left) / width;
    };
    const begin = () => {
      const {min, max} = u.scales.x;
      began = {min, max};
      began.at = [...on.values()].map(timeAt);
    };
    const nearest = t => moment(Math.max(u.valToIdx(t), 0));
    u.over.addEventListener('pointerdown', e => {
      if (e.pointerType !== 'touch') return;
      on.set(e.pointerId, e.clientX);
      begin();
      began.x = e.clientX;
      began.moved = on.size > 1;
    });
    u.over.addEventListener('pointermove', e => {
      if (!on.has(e.pointerId)) return;
      on.set(e.pointerId, e.clientX);
      const [a, b] = [...on.values()].map(timeAt), [c, d] = began.at;
      if (Math.abs(e.clientX - began.x) > 8) began.moved = true;
      if (!began.moved) return;
      const {min, max} = began;
      if (on.size > 1) {
        // What was under each finger stays under it.
        const wide = (max - min) * Math.abs(d - c) / Math.max(Math.abs(b - a), (max - min) / 100);
        const from = (c + d) / 2 - wide * ((a + b) / 2 - min) / (max - min);
        stretch(from, from + wide);
      } else if (max - min < (run.t[run.t.length - 1] - run.t[0]) * 0.999) stretch(min + c - a, max + c - a);
      else nearest(a);
    });
    const end = e => {
      if (!on.delete(e.pointerId)) return;
      if (e.type === 'pointerup' && !began.moved && !on.size) {
        if (e.timeStamp - tapped < 350) zoom(null);
        else nearest(timeAt(e.clientX));
        tapped = e.timeStamp;
      }
      const moved = began.moved;
      if (on.size) { begin(); began.x = [...on.values()][0]; began.moved = moved; }
    };
    u.over.addEventListener('pointerup', end);
    u.over.addEventListener('pointercancel', end);
  };

  // Controls that need a script.
  let slider = null, phases = null;
  const controls = root.querySelector('.controls');
  // On one line, however narrow the page is.
  const labelled = (text, select) => {
    const label = make('label', {textContent: text + ' '});
    label.append(select);
    return label;
  };
  if (controls) {
    const id = key + '-time';
    slider = make('input', {type: 'range', min: 0, max: 1, step: 1, value: 0, id});
    slider.addEventListener('input', () => moment(+slider.value));
    controls.append(make('label', {htmlFor: id, textContent: 'time'}), slider);
    if (bench) {
      // Set by the reader alone: a screen reader follows a choice that changes by itself.
      const select = make('select', {});
      select.append(make('option', {value: '', textContent: 'to be seen'}));
      [1, 2, 5, 10, 20, 50].forEach(k => select.append(make('option', {value: k, textContent: k + ' times'})));
      select.addEventListener('change', () => { enlarged = select.value ? +select.value : null; move(); });
      controls.append(labelled('deviation drawn', select));
    }
    // For those who cannot drag: by keys, on a phone.
    phases = make('select', {});
    phases.addEventListener('change', () => zoom(phases.value === '' ? null : run.spans[+phases.value]));
    const whole = make('button', {type: 'button', textContent: 'whole time'});
    whole.addEventListener('click', () => zoom(null));
    if (data.runs.some(one => one.spans.length)) {
      controls.append(labelled('time shown', phases));
    }
    controls.append(whole);
  }

  // A case has its time.
  const begins = button => {
    const late = button?.dataset.at == null ? -1 : run.t.findIndex(t => t >= +button.dataset.at - 5e-4);
    if (late < 0) return;
    moment(late);
    $(root, 'button[data-at]').forEach(b => b.setAttribute('aria-pressed', String(b === button)));
  };

  // A cell of a table leads to its trial, its channel and its phase.
  const scope = root.closest('main') || root;
  $(scope, 'button[data-run], button[data-goto]').forEach(button => button.addEventListener('click', () => {
    // A trial that is shown already keeps its time.
    if (button.dataset.run != null && +button.dataset.run !== now) choose(+button.dataset.run);
    const figure = figures.find(f => data.plots[+f.dataset.plot].id === button.dataset.goto);
    if (!figure) return;
    const folded = figure.closest('details');
    if (folded) folded.open = true;
    if (!plots.has(figure)) draw(figure);
    const span = run.spans.find(s => s[3] === button.dataset.phase);
    if (span) zoom(span);
    begins(button);
    // What is drawn has words of its own; a figure would be left without.
    const canvas = figure.querySelector('canvas') || figure;
    canvas.tabIndex = -1;
    canvas.focus({preventScroll: true});
    figure.scrollIntoView({block: 'center'});
  }));
  $(root, 'details').forEach(d => d.addEventListener('toggle', () => {
    if (d.open) figures.filter(f => d.contains(f) && !plots.has(f)).forEach(draw);
  }));

  // One channel in all trials.
  const small = root.querySelector('.small');
  if (small && data.runs.length > 1) {
    const channel = make('select', {});
    channel.setAttribute('aria-label', 'channel');
    data.plots.forEach((p, i) => channel.append(make('option', {value: i, textContent: p.unit === '1' ? p.title : `${p.title}, ${p.unit}`})));
    const range = make('span', {className: 'soft range'});
    const tiles = () => {
      const index = +channel.value;
      const runs = data.runs.map((_, k) => read(k));
      // One range for all: what is larger looks larger.
      const all = runs.flatMap(one => one.v[index].flatMap(v => v || [])).filter(x => x != null);
      const [low, high] = all.reduce(([a, b], x) => [Math.min(a, x), Math.max(b, x)], [Infinity, -Infinity]);
      range.textContent = all.length ? `All on one scale, from ${shown(low)} to ${shown(high)}` : '';
      small.replaceChildren(...runs.map((one, k) => {
        const lines = one.v[index], t0 = one.t[0], t1 = one.t[one.t.length - 1];
        const path = v => {
          let d = '';
          v.forEach((y, i) => {
            if (y == null) return;
            d += `${d ? 'L' : 'M'}${(150 * (one.t[i] - t0) / (t1 - t0 || 1)).toFixed(1)} ` +
              (66 - 62 * (y - low) / (high - low || 1)).toFixed(1);
          });
          return d;
        };
        const button = make('button', {type: 'button'});
        const drawn = lines.map((v, i) => v
          ? `<path d="${path(v)}" fill="none" stroke="${css(data.plots[index].lines[i].ink)}" stroke-width="1.4"` +
            `${data.plots[index].lines[i].dash ? ' stroke-dasharray="4 3"' : ''}/>` : '').join('');
        button.innerHTML = `<svg viewBox="0 0 150 70" aria-hidden="true">${drawn}</svg>`;
        button.append(make('span', {textContent: one.words}));
        button.addEventListener('click', () => { choose(k); root.scrollIntoView(); });
        return button;
      }));
    };
    channel.addEventListener('change', tiles);
    small.before(channel, range);
    small.closest('details').addEventListener('toggle', tiles, {once: true});
  }

  const fit = () => plots.forEach((u, f) => {
    const width = f.querySelector('.plot').clientWidth;
    if (width && width !== u.width) u.setSize({width, height: u.height});
  });
  choose(0);
  begins($(root, 'button[data-run="0"]')[0]);
  new ResizeObserver(fit).observe(root);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { drawAll(); moment(at); });
  // Paper is white and narrow.
  addEventListener('beforeprint', () => {
    document.documentElement.classList.add('light');
    drawAll();
    plots.forEach(u => u.setSize({width: 215, height: 130}));
  });
  addEventListener('afterprint', () => {
    document.documentElement.classList.remove('light');
    drawAll();
    moment(at);
  });
});
})();
