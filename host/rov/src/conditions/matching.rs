//! One-to-one assignment of robots to slots: bipartite matching by augmenting paths, and by Hall's theorem the robots that
//! make it impossible.

/// Robots that are too many for the slots they fit into, and those slots; `None` if every robot finds one.
///
/// `fits[robot]` lists its slots. When the search for a robot fails, the robots it went through fit only into slots
/// taken by each other, one fewer than they are.
pub(super) fn crowd(fits: &[Vec<usize>], slots: usize) -> Option<(Vec<usize>, Vec<usize>)> {
    let mut taken: Vec<Option<usize>> = vec![None; slots];
    for robot in 0..fits.len() {
        let mut seen = vec![false; slots];
        if !place(robot, fits, &mut taken, &mut seen) {
            let slots: Vec<usize> = (0..slots).filter(|&slot| seen[slot]).collect();
            let mut robots: Vec<usize> = slots.iter().filter_map(|&slot| taken[slot]).collect();
            robots.push(robot);
            robots.sort_unstable();
            return Some((robots, slots));
        }
    }
    None
}

/// Finds `robot` a slot, moving others on if need be.
fn place(robot: usize, fits: &[Vec<usize>], taken: &mut [Option<usize>], seen: &mut [bool]) -> bool {
    for &slot in &fits[robot] {
        if std::mem::replace(&mut seen[slot], true) {
            continue;
        }
        if taken[slot].is_none_or(|other| place(other, fits, taken, seen)) {
            taken[slot] = Some(robot);
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    use super::*;

    /// Every assignment tried.
    fn possible(fits: &[Vec<usize>], used: &mut Vec<usize>) -> bool {
        let Some(own) = fits.get(used.len()) else { return true };
        own.iter().any(|&slot| {
            if used.contains(&slot) {
                return false;
            }
            used.push(slot);
            let found = possible(fits, used);
            used.pop();
            found
        })
    }

    #[test]
    fn agrees_with_every_assignment_tried_and_blames_a_true_crowd() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut yes, mut no) = (0, 0);
        for round in 0..500 {
            let (robots, slots) = (rng.random_range(1..=6), rng.random_range(1..=7));
            let fits: Vec<Vec<usize>> =
                (0..robots).map(|_| (0..slots).filter(|_| rng.random_bool(0.35)).collect()).collect();
            let found = crowd(&fits, slots);
            assert_eq!(found.is_none(), possible(&fits, &mut Vec::new()), "seed 11, round {round}: {fits:?}");
            if let Some((robots, slots)) = found {
                assert!(robots.len() > slots.len(), "seed 11, round {round}");
                assert!(robots.iter().flat_map(|&robot| &fits[robot]).all(|slot| slots.contains(slot)));
                no += 1;
            } else {
                yes += 1;
            }
        }
        assert!(yes > 50 && no > 50, "{yes} possible, {no} not");
    }
}
