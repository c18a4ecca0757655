// What the page knows of the run: the newest scene and snapshot, and the histories that it draws.

const TRAIL_POINTS = 4000;
const TRAIL_STEP_S = 0.5;
const KEPT = 500;
/** How much of the wrench is drawn, s. */
export const WINDOW_S = 60;

export class State {
  constructor() {
    this.scene = null;
    this.snapshot = null;
    this.clear();
  }

  clear() {
    /** Of boats: [t, x, y, heading]. Of ROVs by id: [t, x, y, z]. */
    this.trail = [];
    this.trails = new Map();
    this.events = [];
    this.decisions = new Map();
    /** [t, demanded, commanded, achieved] */
    this.wrenches = [];
    /** When snapshots came, ms. */
    this.arrivals = [];
  }

  /** Takes one message from the server. @returns its kind */
  take(message) {
    switch (message.kind) {
      case "scene":
        this.scene = message;
        break;
      case "history":
        this.clear();
        this.takeTrail(message.trail);
        this.takeEvents(message.events);
        this.takeDecisions(message.decisions);
        break;
      case "events":
        this.takeEvents(message.events);
        break;
      case "decisions":
        this.takeDecisions(message.decisions);
        break;
      case "snapshot":
        this.takeSnapshot(message);
        break;
      default:
    }
    return message.kind;
  }

  takeTrail(points) {
    if (this.scene?.fleet !== "rovs") {
      this.trail = points;
      return;
    }
    for (const [t, id, ...place] of points) this.robotTrail(id).push([t, ...place]);
  }

  robotTrail(id) {
    if (!this.trails.has(id)) this.trails.set(id, []);
    return this.trails.get(id);
  }

  takeEvents(events) {
    this.events.push(...events);
    this.events.splice(0, this.events.length - KEPT);
  }

  takeDecisions(decisions) {
    for (const decision of decisions) this.decisions.set(decision.index, decision);
    for (const index of this.decisions.keys()) {
      if (this.decisions.size <= KEPT) break;
      this.decisions.delete(index);
    }
  }

  takeSnapshot(snapshot) {
    this.snapshot = snapshot;
    const now = performance.now();
    this.arrivals.push(now);
    while (this.arrivals[0] < now - 2000) this.arrivals.shift();
    const pose = this.pose();
    if (pose) lengthen(this.trail, [snapshot.t_s, ...pose.position_m, pose.heading_rad]);
    for (const robot of snapshot.robots ?? []) lengthen(this.robotTrail(robot.id), [snapshot.t_s, ...robot.position_m]);
    const { wrench } = snapshot;
    // A log that stands still tells the same again.
    if (wrench && snapshot.t_s !== this.wrenches.at(-1)?.[0]) {
      this.wrenches.push([snapshot.t_s, wrench.demanded, wrench.commanded, wrench.achieved]);
      while (this.wrenches[0][0] < snapshot.t_s - WINDOW_S) this.wrenches.shift();
    }
  }

  /** Where the structure is: the water's truth, else the estimate. */
  pose() {
    const { truth, estimate } = this.snapshot ?? {};
    return truth ?? estimate ?? null;
  }

  /** Snapshots a second over the last two seconds. What comes at once after a pause is not taken for a rate. */
  rate() {
    const { arrivals } = this;
    return arrivals.length < 2 ? 0 : ((arrivals.length - 1) * 1000) / Math.max(1000, arrivals.at(-1) - arrivals[0]);
  }
}

function lengthen(trail, point) {
  if (trail.length && point[0] - trail.at(-1)[0] < TRAIL_STEP_S) return;
  trail.push(point);
  if (trail.length > TRAIL_POINTS) trail.shift();
}
