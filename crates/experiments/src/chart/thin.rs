//! Thinning of long curves.

/// The factor by which a curve that runs back, such as an orbit, may keep more points. A choice.
const OF_ORBITS: usize = 3;

/// At most `most` of the points, in their order. The curve is cut into equal stretches, and the
/// lowest and the highest point of each are kept, so that no peak is lost. The first and the last
/// point are kept too. A curve whose x runs back keeps points at equal distances instead, three
/// times as many, as its turns would become polygons.
pub(super) fn thin(points: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    if points.len() <= most {
        return points.to_vec();
    }
    if !points.is_sorted_by(|a, b| a.0 <= b.0) && !points.is_sorted_by(|a, b| a.0 >= b.0) {
        let stride = points.len().div_ceil(OF_ORBITS * most);
        let end = (!(points.len() - 1).is_multiple_of(stride)).then_some(*last);
        return points.iter().step_by(stride).copied().chain(end).collect();
    }
    let stretches = (most.saturating_sub(2) / 2).max(1);
    let inner = &points[1..points.len() - 1];
    let mut kept = vec![*first];
    for k in 0..stretches {
        let stretch = &inner[k * inner.len() / stretches..(k + 1) * inner.len() / stretches];
        let by_height = |a: &usize, b: &usize| stretch[*a].1.total_cmp(&stretch[*b].1);
        let low = (0..stretch.len()).min_by(by_height);
        let high = (0..stretch.len()).max_by(by_height);
        if let (Some(low), Some(high)) = (low, high) {
            kept.push(stretch[low.min(high)]);
            if low != high {
                kept.push(stretch[low.max(high)]);
            }
        }
    }
    kept.push(*last);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_peaks_and_ends() {
        let mut points: Vec<_> =
            (0..20_001).map(|i| (f64::from(i), (f64::from(i) * 0.7).sin())).collect();
        points[7_123].1 = 50.0;
        points[15_001].1 = -50.0;
        let kept = thin(&points, 1500);
        assert!(kept.len() <= 1500 && kept.len() > 1000);
        assert!(kept.contains(&points[7_123]) && kept.contains(&points[15_001]));
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        assert!(kept.is_sorted_by(|a, b| a.0 < b.0));
    }

    #[test]
    fn an_orbit_keeps_points_at_equal_distances() {
        let turn = |i: u32| (f64::from(i) * 0.1).sin_cos();
        let points: Vec<_> = (0..20_001).map(turn).collect();
        let kept = thin(&points, 1500);
        assert!(kept.len() > 3000 && kept.len() <= 4502);
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        assert_eq!(kept[1], points[5]);
    }

    #[test]
    fn short_curves_stay_whole() {
        let points = [(0.0, 1.0), (1.0, 3.0), (2.0, 2.0)];
        assert_eq!(thin(&points, 3), points);
        assert!(thin(&[], 3).is_empty());
    }
}
