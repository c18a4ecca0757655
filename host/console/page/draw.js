// Shapes that both fleets are drawn with. Places are [east, north] in m.

export function polyline(context, camera, points, close = false) {
  context.beginPath();
  points.forEach((point, index) => {
    const [x, y] = camera.toScreen(point);
    if (index) context.lineTo(x, y);
    else context.moveTo(x, y);
  });
  if (close) context.closePath();
}

/** An arrow from a place by a vector in pixels on the screen (y downwards). */
export function arrow(context, [x, y], [dx, dy], colour, width = 2) {
  const length = Math.hypot(dx, dy);
  if (length < 2) return;
  const head = Math.min(9, length);
  const [ux, uy] = [dx / length, dy / length];
  const tip = [x + dx, y + dy];
  context.strokeStyle = colour;
  context.fillStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(tip[0] - ux * head, tip[1] - uy * head);
  context.stroke();
  context.beginPath();
  context.moveTo(...tip);
  context.lineTo(tip[0] - ux * head - uy * head * 0.45, tip[1] - uy * head + ux * head * 0.45);
  context.lineTo(tip[0] - ux * head + uy * head * 0.45, tip[1] - uy * head - ux * head * 0.45);
  context.fill();
}

export function cross(context, [x, y], size, colour) {
  context.strokeStyle = colour;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x - size, y);
  context.lineTo(x + size, y);
  context.moveTo(x, y - size);
  context.lineTo(x, y + size);
  context.stroke();
}

export function label(context, text, [x, y], colour) {
  context.fillStyle = colour;
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "center";
  context.fillText(text, x, y);
  context.textAlign = "start";
}

/** Least distance from a point to a segment. */
function fromSegment([px, py], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const share = Math.min(1, Math.max(0, ((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(px - ax - share * dx, py - ay - share * dy);
}

/** Whether a disc of `radius` that goes straight from `a` to `b` stays inside the polygon. */
export function staysInside(corners, a, b, radius) {
  const edges = corners.map((corner, index) => [corner, corners[(index + 1) % corners.length]]);
  const inside = ([x, y]) =>
    edges.filter(([[ax, ay], [bx, by]]) => ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)).length % 2 === 1;
  const side = ([ax, ay], [bx, by], [x, y]) => Math.sign((bx - ax) * (y - ay) - (by - ay) * (x - ax));
  const apart = ([p, q]) => {
    if (side(p, q, a) !== side(p, q, b) && side(a, b, p) !== side(a, b, q)) return 0;
    return Math.min(fromSegment(a, p, q), fromSegment(b, p, q), fromSegment(p, a, b), fromSegment(q, a, b));
  };
  return inside(a) && inside(b) && edges.every((edge) => apart(edge) >= radius);
}
