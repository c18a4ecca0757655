//! The envelope of a structure: every wrench it could give if each module pushed with up to its greatest thrust in
//! any horizontal direction and no tail were in another's way. What a demand is measured against.
//!
//! The envelope is the sum of one disc of thrusts a module, carried to the centre of mass:
//!
//! W = { Σ (uᵢ, rᵢ × uᵢ) : ‖uᵢ‖ ≤ κᵢ·F(A_max) },  r × u = x·u_y − y·u_x                (e1)
//!
//! It is convex, closed and symmetric about zero, and so described by its support function, the greatest n·w in it:
//!
//! h(n) = F·Σ ‖Mᵢn‖,  Mᵢn = κᵢ·(n_x − n_τ·yᵢ, n_y + n_τ·xᵢ)                            (e2)
//!
//! A wrench w can be multiplied by λ = min { h(n) : n·w = 1 } until it leaves W (the multiplier of the nearest plane
//! that holds W back), and its gauge is 1/λ:
//!
//! gauge(w) = max n·w / h(n)                                                            (e3)
//!
//! Written with the pole c = (−n_y, n_x)/n_τ, the same minimum is that of F·Σ‖rᵢ − c‖ over the torque of w about c.
//! For a pure torque it is the least sum of distances to the modules, Fermat's point.
//!
//! How: with torques divided by the radius of gyration ρ, n = d + B·y over the unit demand d and a basis B of its
//! complement: a convex problem in two unknowns, Σ ‖Mᵢ(d + B·y)‖. Each norm has a kink where Mᵢn = 0, and the least
//! value often sits on one (the middle of three in a row). Each norm is therefore smoothed to sᵢ = √(‖Mᵢn‖² + μ²),
//! solved by Newton's method, and followed as μ → 0: the solution moves on linearly in μ near a kink, and that step is
//! taken along with μ. The thrusts uᵢ = κᵢ·F·Mᵢn/sᵢ of a smoothed solution are allowed and give a multiple of d: a lower
//! bound on λ, which says when to stop.
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | F | N | thrust F(A_max) of law (2) |
//! | rᵢ = (xᵢ, yᵢ) | m | centre of module i in S, from the centre of mass |
//! | κᵢ | – | share of law (2) that module i gives |
//! | w | N, N, N·m | wrench (Fx, Fy, τ) |
//! | n | – , – , 1/m | normal of a plane in the space of wrenches |
//! | ρ | m | radius of gyration √(Σ‖rᵢ‖²/N) of the centres |
//!
//! Limits: the value of (e3) is off by 1e-10 of itself at most. One module alone gives no torque at all.

use quantity::vector::{cross, dot, length};

use super::motion::Wrench;
use super::parameters::Parameters;

/// A gauge up to this counts as inside, so that a wrench of the border, whatever its last digits, does.
pub const ON_BORDER: f64 = 1.0 + 1e-9;
/// Where the bounds on λ have come this close, relative to λ, it is found.
const TOLERANCE: f64 = 1e-11;
/// A step of Newton's method that promises less than this share of the gap between the bounds is not worth taking.
const CENTRED: f64 = 1e-2;
/// Factor on μ from one smoothed problem to the next.
const SHRINK: f64 = 0.03;
/// More steps than any structure needs (about 20).
const STEPS_MAX: usize = 200;

/// The wrenches that a structure could give if no tail were in another's way.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    /// F, N.
    thrust_n: f64,
    /// ρ, m; zero for one module alone.
    gyration_m: f64,
    places: Vec<Place>,
}

/// One module.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    /// rᵢ/ρ.
    at: [f64; 2],
    /// κᵢ.
    share: f64,
}

/// The smoothed problem at one point: Σ over the modules.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Σ‖v‖ and Σs, with v = Mᵢn.
    value: f64,
    smooth: f64,
    /// How far Σ‖v‖ lies above the lower bound, if the gradient is zero.
    gap: f64,
    /// Gradient of Σs, its derivative by μ, and the Hessian (11, 12, 22).
    gradient: [f64; 2],
    drift: [f64; 2],
    hessian: [f64; 3],
}

/// Where the problem of (e3) was solved.
#[derive(Clone, Copy, Debug)]
struct Reached {
    /// The least Σ‖Mᵢn‖.
    sum: f64,
    /// n, with torques divided by ρ, and the μ it was last smoothed by.
    normal: [f64; 3],
    mu: f64,
}

impl Envelope {
    /// Of modules at `positions_m` in S, from the centre of mass, as
    /// [`Structure::positions_m`](super::structure::Structure::positions_m) gives them.
    #[must_use]
    pub fn new(positions_m: &[[f64; 2]], parameters: &Parameters) -> Self {
        let each = positions_m.iter().enumerate();
        Self::of(&each.map(|(place, &r_m)| (r_m, parameters.share(place))).collect::<Vec<_>>(), parameters)
    }

    /// Of these modules alone: where each is, as for [`new`](Self::new), and its share of law (2).
    #[must_use]
    pub fn of(modules: &[([f64; 2], f64)], parameters: &Parameters) -> Self {
        let squares_m2: f64 = modules.iter().map(|([x_m, y_m], _)| x_m * x_m + y_m * y_m).sum();
        let gyration_m = (squares_m2 / modules.len().max(1) as f64).sqrt();
        let scale = if gyration_m > 0.0 { 1.0 / gyration_m } else { 0.0 };
        let place = |&(r_m, share): &([f64; 2], f64)| Place { at: r_m.map(|v| v * scale), share };
        Self {
            thrust_n: parameters.thrust_n(parameters.amplitude_max_rad),
            gyration_m,
            places: modules.iter().map(place).collect(),
        }
    }

    /// Σκᵢ.
    fn shares(&self) -> f64 {
        self.places.iter().map(|place| place.share).sum()
    }

    /// The greatest n·w over the envelope: N for a force, N·m for n = (0, 0, 1). By (e2).
    #[must_use]
    pub fn support(&self, normal: [f64; 3]) -> f64 {
        let n = [normal[0], normal[1], normal[2] * self.gyration_m];
        // h(n) = F·Σ ‖Mᵢn‖                                                              (e2)
        self.thrust_n * self.places.iter().map(|&place| length(carry(place, n))).sum::<f64>()
    }

    /// The share of the envelope that a wrench takes up: 0 at zero, 1 on the border, more outside, +∞ where no
    /// multiple of the wrench can be given at all (a torque on one module alone) or it is no number.
    #[must_use]
    pub fn gauge(&self, wrench: Wrench) -> f64 {
        let Wrench { fx_n, fy_n, tau_nm } = wrench;
        if !wrench.to_array().iter().all(|v| v.is_finite()) {
            return f64::INFINITY;
        }
        if self.gyration_m == 0.0 {
            return match (fx_n.hypot(fy_n), tau_nm) {
                (0.0, 0.0) => 0.0,
                (force_n, 0.0) => force_n / (self.thrust_n * self.shares()),
                _ => f64::INFINITY,
            };
        }
        let demand = [fx_n, fy_n, tau_nm / self.gyration_m];
        let size = demand.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        if size == 0.0 {
            return 0.0;
        }
        // Two steps, so that no square can overflow or vanish.
        let (d, rest) = unit(demand.map(|v| v / size));
        size * rest / (self.thrust_n * self.reach(d).sum)
    }

    /// The thrusts that give `wrench` with the least greatest one: each module pushes along Mᵢn of the plane that holds the
    /// wrench back, all by gauge(w)·κᵢ·F, those where Mᵢn = 0 by less. N in S by module, into `thrusts_n`; none where no multiple of
    /// the wrench can be given.
    pub fn thrusts(&self, wrench: Wrench, thrusts_n: &mut Vec<[f64; 2]>) {
        thrusts_n.clear();
        let gauge = self.gauge(wrench);
        if !gauge.is_finite() {
            return;
        }
        let Wrench { fx_n, fy_n, tau_nm } = wrench;
        if self.gyration_m == 0.0 || gauge == 0.0 {
            let shares = self.shares();
            thrusts_n.extend(
                self.places.iter().map(|Place { share, .. }| [fx_n, fy_n].map(|f_n| f_n * share / shares)),
            );
            return;
        }
        let size = gauge * self.thrust_n;
        let (d, _) = unit([fx_n, fy_n, tau_nm / self.gyration_m].map(|v| v / size));
        let Reached { normal, mu, .. } = self.reach(d);
        thrusts_n.extend(self.places.iter().map(|&place| {
            let v = carry(place, normal);
            let s = (dot(v, v) + mu * mu).sqrt();
            v.map(|v| place.share * size * v / s)
        }));
    }

    /// The farthest wrench of the envelope in the direction of `wrench`; zero where there is none.
    #[must_use]
    pub fn boundary(&self, wrench: Wrench) -> Wrench {
        let gauge = self.gauge(wrench);
        if gauge == 0.0 || gauge.is_infinite() {
            return Wrench::default();
        }
        Wrench::from_array(wrench.to_array().map(|v| v / gauge))
    }

    /// The least Σ‖Mᵢn‖ over n·d = 1 for a unit vector d.
    fn reach(&self, d: [f64; 3]) -> Reached {
        let basis = complement(d);
        let (mut y, mut mu) = ([0.0; 2], 0.5);
        let mut here = self.sums(d, basis, y, mu);
        let mut least = here.value;
        for _ in 0..STEPS_MAX {
            let step = solve(here.hessian, here.gradient.map(|g| -g));
            let promise = -dot(here.gradient, step);
            if promise <= CENTRED * here.gap || promise <= 1e-14 * here.smooth {
                if here.gap <= TOLERANCE * least {
                    break;
                }
                // Solved for this μ. On to the next, along dy/dμ.
                let ahead = solve(here.hessian, here.drift).map(|v| v * (1.0 - SHRINK) * mu);
                y = [y[0] + step[0] + ahead[0], y[1] + step[1] + ahead[1]];
                mu *= SHRINK;
                here = self.sums(d, basis, y, mu);
            } else {
                let mut share = 1.0;
                loop {
                    let next = [y[0] + share * step[0], y[1] + share * step[1]];
                    let there = self.sums(d, basis, next, mu);
                    let bar = here.smooth - 1e-4 * share * promise + 1e-15 * here.smooth;
                    if there.smooth <= bar || share < 1e-6 {
                        (y, here) = (next, there);
                        break;
                    }
                    share *= 0.5;
                }
            }
            // Whatever n is, h(n) is an upper bound.
            least = least.min(here.value);
        }
        Reached { sum: least, normal: normal(d, basis, y), mu }
    }

    /// Value, gradient and Hessian of the smoothed problem at n = d + B·y.
    fn sums(&self, d: [f64; 3], basis: [[f64; 3]; 2], y: [f64; 2], mu: f64) -> Sums {
        let n = normal(d, basis, y);
        let [b, c] = basis;
        let mut sums = Sums::default();
        for &place in &self.places {
            let (v, g_b, g_c) = (carry(place, n), carry(place, b), carry(place, c));
            let square = dot(v, v);
            let (size, s) = (square.sqrt(), (square + mu * mu).sqrt());
            sums.value += size;
            sums.smooth += s;
            // ‖v‖ − v·v/s, without cancellation
            sums.gap += size * mu * mu / (s * (s + size));
            let r = 1.0 / s;
            let (along_b, along_c) = (dot(v, g_b) * r, dot(v, g_c) * r);
            sums.gradient[0] += along_b;
            sums.gradient[1] += along_c;
            // ∂(v/s)/∂μ = −v·μ/s³
            sums.drift[0] -= along_b * mu * r * r;
            sums.drift[1] -= along_c * mu * r * r;
            sums.hessian[0] += (dot(g_b, g_b) - along_b * along_b) * r;
            sums.hessian[1] += (dot(g_b, g_c) - along_b * along_c) * r;
            sums.hessian[2] += (dot(g_c, g_c) - along_c * along_c) * r;
        }
        sums
    }
}

/// n = d + B·y.
fn normal(d: [f64; 3], [b, c]: [[f64; 3]; 2], y: [f64; 2]) -> [f64; 3] {
    [0, 1, 2].map(|k| d[k] + b[k] * y[0] + c[k] * y[1])
}

/// A vector's direction and its length.
fn unit(v: [f64; 3]) -> ([f64; 3], f64) {
    let size = length(v);
    (v.map(|v| v / size), size)
}

/// Mᵢn.
fn carry(Place { at: [x, y], share }: Place, n: [f64; 3]) -> [f64; 2] {
    [n[0] - n[2] * y, n[1] + n[2] * x].map(|part| share * part)
}

/// Two unit vectors at right angles to the unit vector d and to each other.
fn complement(d: [f64; 3]) -> [[f64; 3]; 2] {
    // Away from the axis nearest to d.
    let axis = if d[2].abs() < 0.7 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let b = cross(d, axis);
    let size = b.iter().map(|v| v * v).sum::<f64>().sqrt();
    let b = b.map(|v| v / size);
    [b, cross(d, b)]
}

/// H⁻¹·g for a symmetric H (11, 12, 22) without negative eigenvalues. Where H has no curvature (the problem may be
/// flat between two kinks) a trace of it is lent.
fn solve([a, b, c]: [f64; 3], g: [f64; 2]) -> [f64; 2] {
    let lent = 1e-13 * (a + c);
    let (a, c) = (a + lent, c + lent);
    let det = a * c - b * b;
    [(c * g[0] - b * g[1]) / det, (a * g[1] - b * g[0]) / det]
}

#[cfg(test)]
mod tests;
