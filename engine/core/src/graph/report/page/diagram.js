// The diagram: a column for each step; passes in rows by queue, and below them the heaps.

const COLUMN = 158, NODE_WIDTH = 130, NODE_HEIGHT = 64, LEFT = 16, LANE = 22, GAP = 18;
const SMALLEST = 0.05, LARGEST = 4;

const svg = document.getElementById('diagram');
const view = document.getElementById('view');

/** An SVG element. Text is set as text, never as markup. */
function draw(tag, attributes, ...children) {
  const node = document.createElementNS(svg.namespaceURI, tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

/** A text that fits into so many pixels, by the width of an average letter. */
function shortened(text, width, letter = 7.4) {
  const count = Math.max(1, Math.floor(width / letter));
  const letters = [...text];
  return letters.length <= count ? text : letters.slice(0, Math.max(0, count - 1)).join('') + '…';
}

/** A name in two lines where one is too short, broken at a sign between words if there is one. */
function lines(text, width) {
  if (shortened(text, width) === text) return [text];
  const head = [...shortened(text, width)].slice(0, -1).join('');
  const sign = Math.max(...[' ', '.', '/', '_', '-', ':'].map(sign => head.lastIndexOf(sign))) + 1;
  const first = sign > head.length / 3 ? head.slice(0, sign) : head;
  return [first, shortened(text.slice(first.length), width)];
}

/** How high an edge between two steps of one row goes over the nodes between. */
const rise = (from, to) => (to - from < 2 ? 0 : Math.min(96, 10 + 9 * (to - from - 1)));

/** Draws all of a report; gives the nodes by step and by name of resource, and the edges. */
function diagram(report, words) {
  const drawn = { steps: [], resources: new Map(), edges: [] };
  const queues = ['Graphics', 'Compute', 'Transfer'].filter(q => report.steps.some(step => step.queue === q));
  const x = step => LEFT + step * COLUMN;

  // 1. Rows, each with room for the edges over it.
  const edges = joined(report);
  let y = 6;
  const rows = new Map();
  for (const queue of queues) {
    const inRow = edges.filter(e => report.steps[e.from].queue === queue && report.steps[e.to].queue === queue);
    const room = inRow.reduce((most, e) => Math.max(most, rise(e.from, e.to)), 0);
    rows.set(queue, { label: y + 14, y: y + LANE + room });
    y += LANE + room + NODE_HEIGHT + GAP;
  }
  const top = step => rows.get(report.steps[step].queue).y;

  // 2. Heaps, as high as their share of the bytes.
  const heaps = report.memory.heaps.map(heap => {
    const share = heap.bytes / Math.max(1, report.memory.bytes);
    const place = { heap, label: y + 14, y: y + LANE, height: Math.max(48, Math.round(300 * share)) };
    y += LANE + place.height + GAP;
    return place;
  });
  const width = LEFT * 2 + Math.max(2, report.steps.length) * COLUMN, height = y;
  const below = [], layer = draw('g', {});
  for (let step = 0; step <= report.steps.length; step++) {
    const at = x(step) - (COLUMN - NODE_WIDTH) / 2;
    below.push(draw('line', { class: 'column', x1: at, x2: at, y1: 0, y2: height }));
  }
  for (const [queue, row] of rows) below.push(draw('text', { class: 'lane', x: LEFT, y: row.label }, `${queue} queue`));

  // 3. Edges, behind the nodes.
  for (const edge of edges) {
    const [a, b] = [x(edge.from) + NODE_WIDTH, x(edge.to)], [up, down] = [top(edge.from), top(edge.to)];
    const lift = up === down ? rise(edge.from, edge.to) : 0;
    const middle = NODE_HEIGHT / 2;
    const path = lift
      ? `M${a - 18} ${up} C${a + 20} ${up - lift * 1.33} ${b - 20} ${up - lift * 1.33} ${b + 18} ${up}`
      : `M${a} ${up + middle} C${(a + b) / 2} ${up + middle} ${(a + b) / 2} ${down + middle} ${b} ${down + middle}`;
    const kind = `edge${edge.critical ? ' critical' : ''}${edge.overwrites ? ' overwrites' : ''}`;
    edge.node = draw('path', { class: kind, d: path });
    drawn.edges.push(edge);
    below.push(edge.node);
  }

  // 4. Passes.
  const longest = Math.max(...report.steps.map(step => step.milliseconds ?? 0), 1e-9);
  report.steps.forEach((step, index) => {
    const [left, up] = [x(index), top(index)];
    const time = step.milliseconds === null ? '' : ` · ${words.time(step.milliseconds)}`;
    const barriers = step.barriers.length ? ` · ${words.count(step.barriers.length, 'barrier')}` : '';
    const node = draw('g', {
      class: `node pass-node ${step.queue.toLowerCase()} ${step.kind}`, tabindex: -1, role: 'button',
      'data-step': index, 'aria-label': words.step(index),
    },
    draw('rect', { class: 'box', x: left, y: up, width: NODE_WIDTH, height: NODE_HEIGHT, rx: step.kind === 'pass' ? 7 : 0 }),
    ...lines(step.name, NODE_WIDTH - 12).map((line, row) => draw('text', { x: left + 7, y: up + 18 + 16 * row }, line)),
    draw('text', { class: 'small', x: left + 7, y: up + 52 }, shortened(`${index}${time || barriers}`, NODE_WIDTH - 12, 6)));
    if (step.milliseconds !== null) {
      const share = (NODE_WIDTH - 8) * step.milliseconds / longest;
      node.append(draw('rect', { class: 'time', x: left + 4, y: up + NODE_HEIGHT - 6, width: Math.max(1, share), height: 3 }));
    }
    drawn.steps.push(node);
    layer.append(node);
  });

  // 5. What lies where in memory, and when.
  heaps.forEach(({ heap, label, y: up, height: high }, number) => {
    const left = x(0) - (COLUMN - NODE_WIDTH) / 2, across = report.steps.length * COLUMN;
    below.push(
      draw('text', { class: 'lane', x: LEFT, y: label }, `Heap ${number}: ${words.bytes(heap.bytes)}, from 0 at the top`),
      draw('rect', { class: 'heap', x: left, y: up, width: across, height: high }));
    for (const placed of heap.placements) {
      const [first, last] = placed.steps;
      const box = {
        x: left + first * COLUMN + 1, width: (last - first + 1) * COLUMN - 2,
        y: up + high * placed.offset / heap.bytes, height: Math.max(1.5, high * placed.bytes / heap.bytes),
      };
      const node = draw('g', {
        class: `node resource-node${box.height < 7 ? ' thin' : ''}`, tabindex: -1, role: 'button', 'aria-label': words.resource(placed.resource),
        style: `--hue: ${(words.order(placed.resource) * 137.5) % 360}`,
      }, draw('rect', { class: 'box', ...box }));
      if (box.height >= 13) {
        const name = `${placed.resource}  ${words.bytes(placed.bytes)}`;
        const text = { class: 'small', x: box.x + 6, y: box.y + Math.min(15, box.height / 2 + 4) };
        node.append(draw('text', text, shortened(name, box.width - 12, 6.2)));
      }
      drawn.resources.set(placed.resource, node);
      layer.append(node);
    }
  });
  svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
  const lanes = below.filter(node => node.classList.contains('lane'));
  // Before the nodes are there: what is asked for the size of the view would lay out all of them.
  zoomable(width, height, left => lanes.forEach(lane => lane.setAttribute('x', LEFT + left)));
  svg.append(...below, layer);
  return drawn;
}

/** Dependencies with all resources of one pair of steps together. */
function joined(report) {
  const edges = new Map(), path = report.critical_path ?? [];
  const critical = new Set(path.slice(1).map((step, before) => `${path[before]} ${step}`));
  report.steps.forEach((step, to) => {
    for (const { step: from, resource, overwrites } of step.depends ?? []) {
      const key = `${from} ${to}`;
      const edge = edges.get(key) ?? { from, to, resources: [], overwrites: true, critical: critical.has(key) };
      edge.resources.push(resource);
      edge.overwrites &&= overwrites;
      edges.set(key, edge);
    }
  });
  return [...edges.values()];
}

/**
 * Zoom keeps the point under the pointer where it is; the view scrolls by itself, and a mouse drags it.
 * `moved` is told what of the drawing's width is hidden to the left.
 */
function zoomable(width, height, moved) {
  let scale = 1;
  const zoom = (wanted, clientX, clientY) => {
    const box = view.getBoundingClientRect();
    const [px, py] = [(clientX ?? box.left + box.width / 2) - box.left, (clientY ?? box.top) - box.top];
    const next = Math.min(LARGEST, Math.max(SMALLEST, wanted));
    const [left, top] = [(view.scrollLeft + px) * next / scale - px, (view.scrollTop + py) * next / scale - py];
    scale = next;
    svg.setAttribute('width', width * scale);
    svg.setAttribute('height', height * scale);
    [view.scrollLeft, view.scrollTop] = [left, top];
  };
  const fit = () => zoom(view.clientWidth / width);
  document.getElementById('in').onclick = () => zoom(scale * 1.25);
  document.getElementById('out').onclick = () => zoom(scale / 1.25);
  document.getElementById('fit').onclick = fit;
  view.addEventListener('keydown', event => {
    const by = { '+': () => zoom(scale * 1.25), '=': () => zoom(scale * 1.25), '-': () => zoom(scale / 1.25), 0: fit };
    if (event.ctrlKey || event.metaKey || !by[event.key]) return;
    event.preventDefault();
    by[event.key]();
  });
  view.addEventListener('wheel', event => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoom(scale * Math.exp(-event.deltaY / 200), event.clientX, event.clientY);
  }, { passive: false });

  let apart = null;
  view.addEventListener('touchmove', event => {
    if (event.touches.length !== 2) return;
    event.preventDefault();
    const [a, b] = event.touches;
    const now = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
    if (apart) zoom(scale * now / apart, (a.clientX + b.clientX) / 2, (a.clientY + b.clientY) / 2);
    apart = now;
  }, { passive: false });
  view.addEventListener('touchend', () => { apart = null; });

  let held = null;
  view.addEventListener('pointerdown', event => {
    if (event.pointerType !== 'mouse' || event.button !== 0) return;
    held = { x: event.clientX, y: event.clientY, left: view.scrollLeft, top: view.scrollTop };
  });
  addEventListener('pointermove', event => {
    if (!held) return;
    const [dx, dy] = [event.clientX - held.x, event.clientY - held.y];
    if (Math.hypot(dx, dy) > 4) view.classList.add('dragged');
    if (view.classList.contains('dragged')) [view.scrollLeft, view.scrollTop] = [held.left - dx, held.top - dy];
  });
  // The click that ends a drag chooses nothing; it comes right after.
  addEventListener('pointerup', () => {
    held = null;
    setTimeout(() => view.classList.remove('dragged'));
  });
  view.addEventListener('click', event => {
    if (view.classList.contains('dragged')) event.stopPropagation();
  }, true);

  view.addEventListener('scroll', () => moved(view.scrollLeft / scale), { passive: true });
  zoom(Math.min(1, Math.max(0.9, view.clientWidth / width)));
  [view.scrollLeft, view.scrollTop] = [0, 0];
}
