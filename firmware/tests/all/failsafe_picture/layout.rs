//! Where everything stands, px from the top left corner.

use protocol::ModuleState::{self, *};

/// A point.
pub type Point = (f64, f64);

/// A rectangle.
#[derive(Clone, Copy, Debug)]
pub struct Area {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Area {
    pub fn holds(&self, (x, y): Point) -> bool {
        x > self.left && x < self.right && y > self.top && y < self.bottom
    }

    pub fn contains(&self, other: &Self) -> bool {
        self.left <= other.left
            && self.right >= other.right
            && self.top <= other.top
            && self.bottom >= other.bottom
    }

    pub fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    /// True if `other` lies neither inside nor outside.
    pub fn edge_crosses(&self, other: &Self) -> bool {
        self.overlaps(other) && !self.contains(other)
    }
}

/// Half the width and height of a state's box.
pub const HALF: Point = (84.0, 27.0);

/// A state's box.
pub struct Node {
    pub state: ModuleState,
    pub at: Point,
    /// The line below its name.
    pub does: &'static str,
}

impl Node {
    pub fn area(&self) -> Area {
        let ((x, y), (w, h)) = (self.at, HALF);
        Area { left: x - w, top: y - h, right: x + w, bottom: y + h }
    }
}

const fn node(state: ModuleState, x: f64, y: f64, does: &'static str) -> Node {
    Node { state, at: (x, y), does }
}

/// Every state.
pub const NODES: [Node; 8] = [
    node(Boot, 170.0, 240.0, "looks where it is"),
    node(Unsynchronised, 480.0, 240.0, "holds, awaits the time"),
    node(Arming, 790.0, 240.0, "neutral until obeyed"),
    node(Ready, 1100.0, 240.0, "awaits its first cycle"),
    node(Executing, 1100.0, 460.0, "does its cycle"),
    node(Holding, 790.0, 460.0, "holds where it ended"),
    node(Stopped, 790.0, 710.0, "until released"),
    node(Unprovisioned, 170.0, 710.0, "until the next boot"),
];

/// Around the states that every stop ends.
pub const FRAME: Area = Area { left: 60.0, top: 112.0, right: 1235.0, bottom: 536.0 };

/// The dot at which a module begins.
pub const START: Point = (28.0, 240.0);

/// How a label hangs on its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// An arrow: one cubic Bézier curve, and where its label stands.
pub struct Route {
    /// More than one: from the frame around them.
    pub from: &'static [ModuleState],
    pub to: ModuleState,
    pub curve: [Point; 4],
    /// Of the middle of the label's lines.
    pub label: Point,
    pub anchor: Anchor,
}

impl Route {
    /// Points along it, close together.
    pub fn points(&self) -> Vec<Point> {
        let [a, b, c, d] = self.curve;
        let at = |t: f64, p: [f64; 4]| {
            let s = 1.0 - t;
            s * s * s * p[0] + 3.0 * s * s * t * p[1] + 3.0 * s * t * t * p[2] + t * t * t * p[3]
        };
        (0..=200)
            .map(|k| f64::from(k) / 200.0)
            .map(|t| (at(t, [a.0, b.0, c.0, d.0]), at(t, [a.1, b.1, c.1, d.1])))
            .collect()
    }
}

const fn straight(a: Point, d: Point) -> [Point; 4] {
    let third = ((d.0 - a.0) / 3.0, (d.1 - a.1) / 3.0);
    [a, (a.0 + third.0, a.1 + third.1), (d.0 - third.0, d.1 - third.1), d]
}

const fn route(
    from: &'static [ModuleState],
    to: ModuleState,
    curve: [Point; 4],
    label: Point,
    anchor: Anchor,
) -> Route {
    Route { from, to, curve, label, anchor }
}

use Anchor::{End, Middle, Start};

/// Every arrow.
pub const ROUTES: [Route; 15] = [
    route(&[Boot], Unsynchronised, straight((254.0, 240.0), (396.0, 240.0)), (325.0, 228.0), Middle),
    route(&[Unsynchronised], Arming, straight((564.0, 232.0), (706.0, 232.0)), (635.0, 220.0), Middle),
    route(&[Arming], Ready, straight((874.0, 232.0), (1016.0, 232.0)), (945.0, 220.0), Middle),
    route(&[Ready], Executing, straight((1130.0, 267.0), (1130.0, 433.0)), (1140.0, 350.0), Start),
    route(
        &[Holding],
        Executing,
        [(874.0, 452.0), (915.0, 436.0), (975.0, 436.0), (1016.0, 452.0)],
        (945.0, 428.0),
        Middle,
    ),
    route(
        &[Executing],
        Holding,
        [(1016.0, 470.0), (975.0, 486.0), (915.0, 486.0), (874.0, 470.0)],
        (945.0, 496.0),
        Middle,
    ),
    route(
        &[Ready],
        Arming,
        [(1016.0, 250.0), (975.0, 264.0), (915.0, 264.0), (874.0, 250.0)],
        (945.0, 274.0),
        Middle,
    ),
    route(
        &[Executing],
        Arming,
        [(1050.0, 433.0), (1000.0, 375.0), (900.0, 345.0), (840.0, 267.0)],
        (988.0, 338.0),
        Middle,
    ),
    route(&[Holding], Arming, straight((790.0, 433.0), (790.0, 267.0)), (782.0, 350.0), End),
    route(
        &[Arming],
        Unsynchronised,
        [(706.0, 250.0), (665.0, 264.0), (605.0, 264.0), (564.0, 250.0)],
        (635.0, 282.0),
        Middle,
    ),
    route(
        &[Ready],
        Unsynchronised,
        [(1100.0, 213.0), (1060.0, 135.0), (520.0, 135.0), (480.0, 213.0)],
        (790.0, 134.0),
        Middle,
    ),
    route(
        &[Holding],
        Unsynchronised,
        [(706.0, 460.0), (580.0, 460.0), (490.0, 400.0), (480.0, 267.0)],
        (556.0, 448.0),
        End,
    ),
    route(
        &[Boot, Unsynchronised, Arming, Ready, Executing, Holding],
        Stopped,
        straight((790.0, 536.0), (790.0, 683.0)),
        (802.0, 607.0),
        Start,
    ),
    route(
        &[Stopped],
        Boot,
        [(706.0, 710.0), (430.0, 710.0), (215.0, 520.0), (200.0, 267.0)],
        (432.0, 607.0),
        Start,
    ),
    route(&[Boot], Unprovisioned, straight((150.0, 267.0), (150.0, 683.0)), (160.0, 607.0), Start),
];
