//! From bodies to the pose of a structure: the robust least-squares fit over the bodies that are tracked now, any subset from one on.
//!
//! ```text
//! min over c, ψ of  Σ |c + R(ψ)·b_i − p_i|² / σ_p²  +  Σ 2·(1 − cos(ψ − ψ_i)) / σ_ψ²
//!
//! ψ = atan2( S/σ_p² + Σ sin ψ_i/σ_ψ²,  C/σ_p² + Σ cos ψ_i/σ_ψ² ),   c = p̄ − R(ψ)·b̄
//! C = Σ (b_i − b̄)·(p_i − p̄),   S = Σ (b_i − b̄)×(p_i − p̄)
//! ```
//!
//! | symbol | what | unit |
//! |---|---|---|
//! | b_i | place of module i's pivot in the structure's frame | m |
//! | p_i, ψ_i | the pivot in the world and the module's angle, from its body | m, rad |
//! | c, ψ | the structure's origin in the world and the angle of its x axis (sway) from the world's | m, rad |
//! | σ_p, σ_ψ | noise of a body's position and heading | m, rad |
//!
//! For small ψ − ψ_i the second sum is the squared error of the headings; written so, the minimum has a closed form (Umeyama 1991 for
//! the first sum). The heading Θ of the surge axis is ψ + π/2.
//!
//! Bodies that do not fit are found by consensus (Fischler and Bolles 1981): each body alone gives a pose of the structure; the one
//! that most others fit is refined over those. With two bodies that contradict each other the one nearer to where the structure
//! should be is right. Of bodies that do not fit, two whose places exchanged fit are *swapped*; any other is *astray*: its module
//! has broken away, or its body has been moved on it.
//!
//! Limits: two bodies alone that are mounted half a turn apart look the same with exchanged labels as with the structure turned about.
//! A single body is believed. Of two halves of a structure that has broken in the middle neither is right without an expectation.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Rotation2, Vector2};

use crate::axes::Pose;
use crate::frame::Label;
use crate::roster::{Entry, Roster};

/// Bodies that are tried as the only right one; the others join by consensus all the same.
const MOST_TRIED: usize = 24;
/// Bodies among which every pair is tried as swapped; with more, only those that do not fit.
const FEW: usize = 8;
/// Pairs of swapped bodies that are looked for.
const MOST_SWAPS: usize = 4;

/// What is known of the bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// σ_p, m.
    pub noise_m: f64,
    /// σ_ψ, rad.
    pub noise_rad: f64,
    /// A body further from its place does not fit, m.
    pub off_m: f64,
    /// A body turned further from its direction does not fit, rad.
    pub off_rad: f64,
}

impl Default for Tolerances {
    /// *Assumed*: 2 mm and 0.01 rad of noise; a body is mounted to within 2 cm and 0.2 rad, and what has broken away is further off.
    fn default() -> Self {
        Self { noise_m: 0.002, noise_rad: 0.01, off_m: 0.02, off_rad: 0.2 }
    }
}

/// A pose in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarPose {
    /// The structure's origin in the world, m.
    pub position_m: Vector2<f64>,
    /// Θ: the heading of its surge axis, rad, in [−π, π).
    pub heading_rad: f64,
}

/// A body that does not fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Astray {
    /// The module it stands for.
    pub module: u16,
    /// The body.
    pub label: Label,
    /// How far from its place, m.
    pub off_m: f64,
    /// How far from its direction, rad.
    pub off_rad: f64,
}

/// A structure's pose, and what does not fit it.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Where the structure is.
    pub pose: PlanarPose,
    /// Root mean square distance of the bodies that fit from their places, m.
    pub residual_m: f64,
    /// Modules whose bodies fit.
    pub used: Vec<u16>,
    /// Pairs of modules whose bodies stand in each other's place, the lower number first.
    pub swapped: Vec<(u16, u16)>,
    /// Bodies that fit nowhere.
    pub astray: Vec<Astray>,
}

/// What the bodies say.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Where the structure is.
    Found(Found),
    /// No body of the roster is tracked.
    Unseen,
    /// Bodies contradict each other, and nothing says which is right: the modules, by their bodies.
    Contradiction(Vec<u16>),
}

/// A structure: where its modules sit, and which body is which.
#[derive(Clone, Debug)]
pub struct Structure {
    roster: Roster,
    /// For each entry the place of its module's pivot in the structure's frame, m; `None` for a module of another structure.
    places: Vec<Option<Vector2<f64>>>,
    tolerances: Tolerances,
}

/// A body that was seen.
#[derive(Clone, Copy, Debug)]
struct Seen<'a> {
    label: &'a Label,
    entry: &'a Entry,
    body: Pose,
    place: Vector2<f64>,
    pivot: Vector2<f64>,
    angle: f64,
}

/// A pose of the structure that is tried: origin and ψ.
#[derive(Clone, Copy, Debug)]
struct Trial {
    origin: Vector2<f64>,
    angle: f64,
    rotation: Rotation2<f64>,
}

impl Structure {
    /// A structure of modules at `places` in its frame (x sway, y surge, origin at its centre of mass). Entries of the roster for other
    /// modules are left aside.
    pub fn new(roster: Roster, places: &[(u16, Vector2<f64>)], tolerances: Tolerances) -> Self {
        let place = |entry: &Entry| {
            places.iter().find(|(module, _)| *module == entry.module).map(|(_, place)| *place)
        };
        let places = roster.entries().iter().map(place).collect();
        Self { roster, places, tolerances }
    }

    /// Where the structure is, of the bodies of a fix in the world. `expected` is where it should be by now: it decides between
    /// bodies that contradict each other.
    pub fn locate(&self, bodies: &[(Label, Pose)], expected: Option<&PlanarPose>) -> Outcome {
        let mut seen = self.seen(bodies);
        if seen.is_empty() {
            return Outcome::Unseen;
        }
        let mut swapped = Vec::new();
        let Some((mut trial, mut fits)) = self.consensus(&seen, expected) else {
            return match self.exchanged(&seen, None, &[]) {
                Some((pair, trial)) => {
                    let modules = exchange(&mut seen, pair);
                    self.found(&seen, trial, vec![modules])
                }
                None => Outcome::Contradiction(seen.iter().map(|one| one.entry.module).collect()),
            };
        };
        while swapped.len() < MOST_SWAPS
            && let Some((pair, better)) = self.exchanged(&seen, Some(trial), &fits)
        {
            swapped.push(exchange(&mut seen, pair));
            trial = better;
            fits = self.fitting(&seen, trial, 1.0);
        }
        self.found(&seen, trial, swapped)
    }

    /// The bodies that stand for modules of this structure.
    fn seen<'a>(&'a self, bodies: &'a [(Label, Pose)]) -> Vec<Seen<'a>> {
        let seen = bodies.iter().filter_map(|(label, body)| {
            let at = self.roster.place_of(label)?;
            let (entry, place) = (self.roster.entries().get(at)?, (*self.places.get(at)?)?);
            Some(Seen::new(label, entry, *body, place))
        });
        seen.collect()
    }

    /// The pose that most bodies fit, and which do; `None` where as many fit another that contradicts it.
    fn consensus(&self, seen: &[Seen<'_>], expected: Option<&PlanarPose>) -> Option<(Trial, Vec<usize>)> {
        let stride = seen.len().div_ceil(MOST_TRIED);
        let mut best: Vec<(Trial, Vec<usize>)> = Vec::new();
        for one in seen.iter().step_by(stride) {
            // One heading's noise moves places far off.
            let mut fits = self.fitting(seen, one.alone(), 2.0);
            let mut trial = one.alone();
            for _refined in 0..3 {
                trial = self.least_squares(fits.iter().filter_map(|&at| seen.get(at)))?;
                fits = self.fitting(seen, trial, 1.0);
                if fits.is_empty() {
                    break;
                }
            }
            if fits.len() == seen.len() {
                return Some((trial, fits));
            }
            let most = best.first().map_or(1, |(_, fits)| fits.len());
            if fits.len() > most {
                best.clear();
            }
            // Two sets that share most of their bodies are one, but for a body at the edge of its tolerance.
            let shares = |known: &Vec<usize>| {
                2 * fits.iter().filter(|at| known.binary_search(at).is_ok()).count() > fits.len()
            };
            if fits.len() >= most && !best.iter().any(|(_, known)| shares(known)) {
                best.push((trial, fits));
            }
        }
        if best.len() > 1 {
            let expected = expected?;
            let off = |trial: &Trial| {
                let pose = trial.pose();
                let turned = wrapped(pose.heading_rad - expected.heading_rad) * self.tolerances.off_m
                    / self.tolerances.off_rad;
                (pose.position_m - expected.position_m).norm().hypot(turned)
            };
            best.sort_by(|(a, _), (b, _)| off(a).total_cmp(&off(b)));
        }
        best.into_iter().next()
    }

    /// Two bodies that fit better in each other's place: both fit then, and more in all than `fitted`.
    fn exchanged(
        &self,
        seen: &[Seen<'_>],
        trial: Option<Trial>,
        fitted: &[usize],
    ) -> Option<((usize, usize), Trial)> {
        let few = seen.len() <= FEW;
        let outside = |at: &usize| fitted.binary_search(at).is_err();
        if (0..seen.len()).all(|at| !outside(&at)) {
            return None;
        }
        let tried: Vec<usize> = (0..seen.len()).filter(|at| few || outside(at)).take(MOST_TRIED).collect();
        let mut best: Option<((usize, usize), Trial, usize)> = None;
        for (count, &a) in tried.iter().enumerate() {
            for &b in tried.iter().skip(count + 1) {
                let mut other = seen.to_vec();
                exchange(&mut other, (a, b));
                // With many bodies the pose stands, and only the two are tried in it.
                let found = if few {
                    self.consensus(&other, None)
                } else {
                    trial.map(|trial| (trial, self.fitting(&other, trial, 1.0)))
                };
                let Some((trial, fits)) = found else { continue };
                let most = best.as_ref().map_or(fitted.len(), |(.., most)| *most);
                if fits.contains(&a) && fits.contains(&b) && fits.len() > most {
                    best = Some(((a, b), trial, fits.len()));
                }
            }
        }
        best.map(|(pair, trial, _)| (pair, trial))
    }

    /// The bodies within `wide` times the tolerances of a trial, in ascending order.
    fn fitting(&self, seen: &[Seen<'_>], trial: Trial, wide: f64) -> Vec<usize> {
        let within = |one: &Seen<'_>| {
            let (off_m, off_rad) = one.off(trial);
            off_m <= wide * self.tolerances.off_m && off_rad <= wide * self.tolerances.off_rad
        };
        seen.iter().enumerate().filter(|(_, one)| within(one)).map(|(at, _)| at).collect()
    }

    fn least_squares<'a>(&self, bodies: impl Iterator<Item = &'a Seen<'a>> + Clone) -> Option<Trial> {
        #[expect(clippy::cast_precision_loss, reason = "at most 1000 bodies")]
        let count = bodies.clone().count() as f64;
        if count < 1.0 {
            return None;
        }
        let mean_place = bodies.clone().map(|one| one.place).sum::<Vector2<f64>>() / count;
        let mean_pivot = bodies.clone().map(|one| one.pivot).sum::<Vector2<f64>>() / count;
        let (by_place, by_angle) = (self.tolerances.noise_m.powi(-2), self.tolerances.noise_rad.powi(-2));
        let (mut sine, mut cosine) = (0.0, 0.0);
        for one in bodies {
            let (b, p) = (one.place - mean_place, one.pivot - mean_pivot);
            sine += by_place * b.perp(&p) + by_angle * one.angle.sin();
            cosine += by_place * b.dot(&p) + by_angle * one.angle.cos();
        }
        let angle = sine.atan2(cosine);
        Some(Trial::about(mean_place, mean_pivot, angle))
    }

    fn found(&self, seen: &[Seen<'_>], trial: Trial, swapped: Vec<(u16, u16)>) -> Outcome {
        let fits = self.fitting(seen, trial, 1.0);
        let fitting = fits.iter().filter_map(|&at| seen.get(at));
        let (squares, used): (Vec<f64>, Vec<u16>) =
            fitting.map(|one| (one.off(trial).0.powi(2), one.entry.module)).unzip();
        let astray =
            seen.iter().enumerate().filter(|(at, _)| fits.binary_search(at).is_err()).map(|(_, one)| {
                let (off_m, off_rad) = one.off(trial);
                Astray { module: one.entry.module, label: one.label.clone(), off_m, off_rad }
            });
        #[expect(clippy::cast_precision_loss, reason = "at most 1000 bodies")]
        let residual_m = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
        Outcome::Found(Found { pose: trial.pose(), residual_m, used, swapped, astray: astray.collect() })
    }
}

impl<'a> Seen<'a> {
    fn new(label: &'a Label, entry: &'a Entry, body: Pose, place: Vector2<f64>) -> Self {
        let boat = entry.boat(&body);
        let angle = crate::axes::heading_rad(&boat.attitude);
        Self { label, entry, body, place, pivot: boat.position.xy(), angle }
    }

    /// The structure's pose of this body alone.
    fn alone(&self) -> Trial {
        Trial::about(self.place, self.pivot, self.angle)
    }

    /// How far the body is from its place, m, and from its direction, rad.
    fn off(&self, trial: Trial) -> (f64, f64) {
        let place = trial.origin + trial.rotation * self.place;
        ((place - self.pivot).norm(), wrapped(self.angle - trial.angle).abs())
    }
}

impl Trial {
    /// The pose with this angle that brings a place of the structure to a point of the world.
    fn about(place: Vector2<f64>, point: Vector2<f64>, angle: f64) -> Self {
        let rotation = Rotation2::new(angle);
        Self { origin: point - rotation * place, angle, rotation }
    }

    fn pose(self) -> PlanarPose {
        PlanarPose { position_m: self.origin, heading_rad: wrapped(self.angle + FRAC_PI_2) }
    }
}

/// Exchanges the bodies of two modules; which modules, the lower number first.
fn exchange(seen: &mut [Seen<'_>], (a, b): (usize, usize)) -> (u16, u16) {
    let (Some(first), Some(second)) = (seen.get(a).copied(), seen.get(b).copied()) else { return (0, 0) };
    let (one, other) = (first.entry.module, second.entry.module);
    let swapped = [
        (a, Seen::new(second.label, first.entry, second.body, first.place)),
        (b, Seen::new(first.label, second.entry, first.body, second.place)),
    ];
    for (at, swapped) in swapped {
        if let Some(place) = seen.get_mut(at) {
            *place = swapped;
        }
    }
    (one.min(other), one.max(other))
}

/// An angle in [−π, π).
fn wrapped(angle: f64) -> f64 {
    (angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
}
