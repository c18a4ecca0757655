// Top and side view of ROVs: hulls, thrust arrows, trails, slots, tools, and the paths of the moves.
// The world is NED: [north, east, down]. The top view shows [east, north], the side view [east, −down].

import { arrow, label, polyline } from "./draw.js";

export const above = ([north, east]) => [east, north];
export const aside = ([, east, down]) => [east, -down];

export function extent(state, view) {
  const { rovs } = state.scene;
  const around = (place) => [-0.4, 0.4].map((room) => view(place).map((at) => at + room));
  const places = [...rovs.slots, ...rovs.tools.map((tool) => tool.pose)].map((pose) => pose.slice(0, 3));
  places.push(...(state.snapshot?.robots ?? []).map((robot) => robot.position_m));
  places.push(...(rovs.plan?.moves ?? []).flatMap((move) => move.path));
  return places.flatMap(around);
}

export function draw(context, camera, state, colours, view) {
  const { rovs } = state.scene;
  const { snapshot } = state;
  const box = rovs.robots[0]?.box_m ?? [0.4, 0.3, 0.3];
  for (const slot of rovs.slots) {
    outline(context, camera, slot.slice(0, 3), [0, 0, slot[3]], box, view);
    context.setLineDash([4, 4]);
    context.strokeStyle = colours.target;
    context.lineWidth = 1.5;
    context.stroke();
    context.setLineDash([]);
  }
  for (const tool of rovs.tools) {
    outline(context, camera, tool.pose.slice(0, 3), [0, 0, tool.pose[3]], tool.box_m, view);
    context.fillStyle = colours.quiet;
    context.globalAlpha = 0.5;
    context.fill();
    context.globalAlpha = 1;
  }
  paths(context, camera, state, colours, view);
  for (const trail of state.trails.values()) {
    polyline(context, camera, trail.map(([, ...place]) => view(place)));
    context.strokeStyle = colours.trail;
    context.lineWidth = 2;
    context.stroke();
  }
  for (const robot of snapshot.robots ?? []) {
    const made = rovs.robots.find(({ id }) => id === robot.id);
    if (made) hull(context, camera, robot, made, colours, view);
  }
}

/** Of moves that overlap several are under way; one that has not ended has no deviation. */
export const isUnderWay = (moves, index) => index === moves?.moving || moves?.done[index]?.end_m === null;

function paths(context, camera, state, colours, view) {
  const { moves } = state.snapshot;
  (state.scene.rovs.plan?.moves ?? []).forEach((move, index) => {
    const now = isUnderWay(moves, index);
    polyline(context, camera, move.path.map(view));
    context.strokeStyle = now ? colours.target : colours.commanded;
    context.lineWidth = now ? 2.5 : 1;
    context.setLineDash(now ? [] : [3, 4]);
    context.stroke();
    context.setLineDash([]);
  });
}

function hull(context, camera, robot, made, colours, view) {
  outline(context, camera, robot.position_m, robot.attitude_rad, made.box_m, view);
  const paint = robot.moving ? colours.tail : colours.hull;
  context.fillStyle = paint;
  context.globalAlpha = 0.35;
  context.fill();
  context.globalAlpha = 1;
  context.strokeStyle = paint;
  context.lineWidth = 1.5;
  context.stroke();
  const place = (body) => camera.toScreen(view(add(robot.position_m, rotate(robot.attitude_rad, body))));
  const centre = place([0, 0, 0]);
  const front = place([made.box_m[0] / 2, 0, 0]);
  context.beginPath();
  context.moveTo(...centre);
  context.lineTo(...front);
  context.stroke();
  made.thrusters.forEach((thruster, index) => {
    const thrust = robot.thrusts_n?.[index] ?? 0;
    const reach = (thrust / made.thrust_max_n[0]) * made.box_m[0] * 3;
    const from = place(thruster.position_m);
    const to = place(thruster.position_m.map((at, k) => at + thruster.direction[k] * reach));
    arrow(context, from, [to[0] - from[0], to[1] - from[1]], colours.ink, 2);
  });
  label(context, robot.id, [centre[0], centre[1] + 4], colours.ink);
}

/** The silhouette of a box: the convex hull of its eight corners, as seen. */
function outline(context, camera, position, attitude, box, view) {
  const corners = [];
  for (const a of [-0.5, 0.5]) {
    for (const b of [-0.5, 0.5]) {
      for (const c of [-0.5, 0.5]) corners.push(view(add(position, rotate(attitude, [a * box[0], b * box[1], c * box[2]]))));
    }
  }
  polyline(context, camera, convex(corners), true);
}

const add = (a, b) => a.map((value, k) => value + b[k]);

/** ZYX Euler angles: from the body (forward, right, down) to NED. */
function rotate([roll, pitch, yaw], [x, y, z]) {
  const [sr, cr, sp, cp, sy, cy] = [roll, pitch, yaw].flatMap((angle) => [Math.sin(angle), Math.cos(angle)]);
  return [
    cy * cp * x + (cy * sp * sr - sy * cr) * y + (cy * sp * cr + sy * sr) * z,
    sy * cp * x + (sy * sp * sr + cy * cr) * y + (sy * sp * cr - cy * sr) * z,
    -sp * x + cp * sr * y + cp * cr * z,
  ];
}

/** Andrew's monotone chain. */
function convex(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const turn = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const chain = (all) => {
    const kept = [];
    for (const point of all) {
      while (kept.length > 1 && turn(kept.at(-2), kept.at(-1), point) <= 0) kept.pop();
      kept.push(point);
    }
    kept.pop();
    return kept;
  };
  return [...chain(sorted), ...chain(sorted.reverse())];
}
