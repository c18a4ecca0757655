// Top view of docked Modboats: structure with moving tails, trail, target, water's edge, tracked bodies, current.

import { arrow, cross, label, polyline, staysInside } from "./draw.js";

/** Half the diagonal of everything that is docked, m: no part of a hull is farther from the centre. */
const radius = (boats) => Math.max(0, ...boats.centres_m.map((place) => Math.hypot(...place))) + boats.pitch_m * Math.SQRT1_2;

/** From the centre to the end of the farthest hull or tail, however the tails stand, m: the module's footprint is a disc, as the governor's. */
const footprint = (boats) =>
  Math.max(0, ...boats.centres_m.map((place) => Math.hypot(...place))) + Math.max(boats.pitch_m * Math.SQRT1_2, boats.tail_m + boats.tail_width_m / 2);

/** From the structure's frame (sway, surge) to the world. */
const toWorld = ({ position_m: [x, y], heading_rad: heading }, [sway, surge]) => [
  x + sway * Math.sin(heading) + surge * Math.cos(heading),
  y - sway * Math.cos(heading) + surge * Math.sin(heading),
];

/** The structure and what is near it: what is shown first. */
export function surroundings(state) {
  const { position_m: place } = state.pose();
  const reach = 3 * radius(state.scene.boats) + 0.2;
  return [-1, 1].map((sign) => place.map((at) => at + sign * reach));
}

/** Everything worth showing at once. */
export function extent(state) {
  const { boats } = state.scene;
  const pose = state.pose();
  const reach = radius(boats) + boats.pitch_m;
  const places = boats.bounds ? [...boats.bounds.corners_m] : [];
  if (pose) places.push(...[-1, 1].map((sign) => pose.position_m.map((at) => at + sign * reach)));
  places.push(...state.trail.map(([, x, y]) => [x, y]));
  const target = state.snapshot?.target;
  if (target?.station_m) places.push(target.station_m);
  return places;
}

export function draw(context, camera, state, colours, preview) {
  const { boats } = state.scene;
  const { snapshot } = state;
  water(context, camera, boats.bounds, colours);
  context.strokeStyle = colours.trail;
  context.lineWidth = 2;
  polyline(context, camera, state.trail.map(([, x, y]) => [x, y]));
  context.stroke();
  const pose = state.pose();
  if (pose) structure(context, camera, state, pose, colours);
  target(context, camera, state, colours);
  if (snapshot.truth && snapshot.estimate) {
    cross(context, camera.toScreen(snapshot.estimate.position_m), 5, colours.good);
  }
  for (const body of snapshot.poses?.bodies ?? []) {
    const [x, y] = camera.toScreen(body.position_m);
    context.strokeStyle = body.used ? colours.good : colours.bad;
    context.lineWidth = 1.5;
    context.strokeRect(x - 4, y - 4, 8, 8);
    if (!body.used) label(context, body.name, [x, y - 8], colours.bad);
  }
  current(context, camera, snapshot, colours);
  if (preview) route(context, camera, state, preview, colours);
}

function water(context, camera, bounds, colours) {
  if (!bounds) return;
  polyline(context, camera, bounds.corners_m, true);
  context.strokeStyle = colours.ink;
  context.lineWidth = 3;
  context.stroke();
}

function structure(context, camera, state, pose, colours) {
  const { boats, modules } = state.scene;
  const { snapshot } = state;
  const half = boats.pitch_m / 2;
  boats.centres_m.forEach(([sway, surge], index) => {
    const module = snapshot.modules[index];
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => toWorld(pose, [sway + a * half * 0.94, surge + b * half * 0.94]));
    polyline(context, camera, corners, true);
    context.fillStyle = fill(module, colours);
    context.globalAlpha = 0.35;
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = fill(module, colours);
    context.lineWidth = 1.5;
    context.stroke();
  });
  boats.centres_m.forEach((centre, index) => {
    const module = snapshot.modules[index];
    const from = camera.toScreen(toWorld(pose, centre));
    if (module?.tail_rad !== null && module?.tail_rad !== undefined) {
      const [sway, surge] = [Math.cos(module.tail_rad), Math.sin(module.tail_rad)];
      const tip = camera.toScreen(toWorld(pose, [centre[0] + sway * boats.tail_m, centre[1] + surge * boats.tail_m]));
      context.strokeStyle = colours.tail;
      context.globalAlpha = 0.6;
      context.lineCap = "round";
      context.lineWidth = Math.max(2, boats.tail_width_m * camera.scale);
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...tip);
      context.stroke();
      context.lineCap = "butt";
      context.globalAlpha = 1;
    }
    if (camera.scale * boats.pitch_m > 18) label(context, modules[index], [from[0], from[1] + 4], colours.ink);
  });
  const front = toWorld(pose, [0, radius(boats)]);
  const [a, b] = [camera.toScreen(pose.position_m), camera.toScreen(front)];
  arrow(context, a, [b[0] - a[0], b[1] - a[1]], colours.ink, 1.5);
}

function fill(module, colours) {
  if (!module || module.stale || module.state === null) return colours.quiet;
  if (module.state === "Stopped" || module.faults.length) return colours.bad;
  return ["Executing", "Ready"].includes(module.state) ? colours.hull : colours.warn;
}

function target(context, camera, state, colours) {
  const { target: wanted } = state.snapshot;
  const pose = state.pose();
  if (!wanted || wanted.kind === "none" || !pose) return;
  const from = camera.toScreen(pose.position_m);
  if (wanted.kind === "velocity" && wanted.velocity_m_s) {
    arrow(context, from, pixels(wanted.velocity_m_s, state.scene.boats), colours.target, 3);
  }
  const places = wanted.kind === "waypoints" ? wanted.waypoints_m : wanted.station_m ? [wanted.station_m] : [];
  context.setLineDash([6, 5]);
  context.strokeStyle = colours.target;
  context.lineWidth = 1.5;
  polyline(context, camera, [pose.position_m, ...places]);
  if (places.length) context.stroke();
  context.setLineDash([]);
  for (const place of places) cross(context, camera.toScreen(place), 9, colours.target);
  if (wanted.heading_rad !== null) {
    const length = radius(state.scene.boats) * camera.scale + 22;
    const [dx, dy] = [Math.cos(wanted.heading_rad), -Math.sin(wanted.heading_rad)];
    context.setLineDash([2, 4]);
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(from[0] + dx * length, from[1] + dy * length);
    context.stroke();
    context.setLineDash([]);
  }
}

/** Length of the arrow of the greatest speed, pixels: the same scale for the drag that asks for a velocity. */
export const FULL_SPEED_PX = 110;

const pixels = ([east, north], boats) => [(east / boats.speed_max_m_s) * FULL_SPEED_PX, (-north / boats.speed_max_m_s) * FULL_SPEED_PX];

/** The acceleration that nothing known explains, as an arrow in the corner: 1 mm/s² is 10 pixels. */
function current(context, camera, snapshot, colours) {
  const force = snapshot.current?.force_m_s2;
  if (!force) return;
  const at = [camera.canvas.clientWidth - 60, 60];
  const [dx, dy] = [force[0] * 1e4, -force[1] * 1e4];
  const shorten = Math.min(1, 45 / Math.hypot(dx, dy));
  arrow(context, at, [dx * shorten, dy * shorten], colours.good, 2);
  label(context, `unexplained ${(Math.hypot(...force) * 1000).toFixed(2)} mm/s²`, [at[0] - 14, at[1] - 50 + 8], colours.quiet);
}

/** A path that is not sent yet: red where hull or tails would come too near to the water's edge. */
function route(context, camera, state, places, colours) {
  const { boats } = state.scene;
  const pose = state.pose();
  const all = pose ? [pose.position_m, ...places] : places;
  all.slice(1).forEach((place, index) => {
    context.strokeStyle = isInside(boats, all[index], place) ? colours.target : colours.bad;
    context.lineWidth = 2.5;
    polyline(context, camera, [all[index], place]);
    context.stroke();
    const at = camera.toScreen(place);
    cross(context, at, 6, context.strokeStyle);
    label(context, index + 1, [at[0] + 10, at[1] - 8], colours.ink);
  });
}

export const isInside = (boats, a, b) => !boats.bounds || staysInside(boats.bounds.corners_m, a, b, footprint(boats) + boats.bounds.margin_m);
