//! How far the linear band is believed where it is (step 7 of the learned method): it grows with the displacements for ever, and
//! where the examples do not predict each other, a pose that none of them shows must not be theirs many times over.
use super::choice::Prediction;
use super::neighborhoods::{LinearInfluences, Listens};
use rayon::prelude::*;

/// Parts of the squares that are predicted in examples that are left out: from the second on the band is believed in full, up to the
/// first not at all.
const BELIEVED: [f64; 2] = [0.4, 0.5];

/// How much the whole face counts at each handle, in a mean handle's sample: a few vertices alone say little.
const OF_ALL: f64 = 0.25;

/// t of every vertex, in 0..1: of each of its nearest handles `1 − Σ|e|²/Σ|Ŵ|²`, from 0 at 0.4 to 1 at 0.5, and the mean of these by
/// ν. The sums are over the sample around a handle, by ν, and a quarter of their mean over all handles. It is 1 in parts without a
/// handle, which have nothing else, and where there is no sample.
///
/// `listens` is V long; F is `strain_edges`, H is `handles`.
pub(crate) fn trust(
    predictions: &[Prediction],
    influences: &LinearInfluences,
    listens: &[Listens],
    strain_edges: usize,
    handles: usize,
) -> Vec<f64> {
    let anchors = |v: usize| {
        let of_vertex = v * influences.per_vertex..(v + 1) * influences.per_vertex;
        let both = influences.features[of_vertex.clone()].iter().zip(&influences.weights[of_vertex]);
        both.filter_map(|(&e, &nu)| Some(((e as usize).checked_sub(strain_edges)?, nu)))
    };
    let (mut errors, mut sizes) = (vec![0.0; handles], vec![0.0; handles]);
    for prediction in predictions {
        for (h, nu) in anchors(prediction.vertex as usize) {
            errors[h] += nu * prediction.error;
            sizes[h] += nu * prediction.size;
        }
    }
    let of_all = |sums: &[f64]| OF_ALL * sums.iter().sum::<f64>() / handles as f64;
    let (all_errors, all_sizes) = (of_all(&errors), of_all(&sizes));
    let [least, most] = BELIEVED;
    let believed = |(error, size): (&f64, &f64)| {
        let predicted = 1.0 - (error + all_errors) / (size + all_sizes);
        // Nothing to predict: nothing to doubt.
        if predicted.is_nan() { 1.0 } else { ((predicted - least) / (most - least)).clamp(0.0, 1.0) }
    };
    let of_handle: Vec<f64> = errors.iter().zip(&sizes).map(believed).collect();
    let of_vertex = |(v, listens): (usize, &Listens)| {
        if *listens != Listens::Itself {
            return 1.0;
        }
        let (mut sum, mut all) = (0.0, 0.0);
        for (h, nu) in anchors(v) {
            sum += nu * of_handle[h];
            all += nu;
        }
        if all > 0.0 { sum / all } else { 1.0 }
    };
    listens.par_iter().enumerate().map(of_vertex).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two strain edges, and two handles with three vertices each, of which the last is between them; one more follows.
    #[test]
    fn what_is_predicted_by_half_is_believed() {
        let influences = LinearInfluences {
            features: [[0, 2, 3], [0, 2, 3], [1, 2, 3], [1, 2, 3]].concat(),
            weights: [[0.9, 0.1, 0.0], [0.9, 0.0, 0.1], [0.9, 0.05, 0.05], [0.0, 0.5, 0.5]].concat(),
            per_vertex: 3,
        };
        let listens = [Listens::Itself, Listens::Itself, Listens::Itself, Listens::As(0)];
        let of = |errors: [f64; 2]| {
            let predictions = [0, 1].map(|v| Prediction { vertex: v, error: errors[v as usize], size: 4.0 });
            trust(&predictions, &influences, &listens, 2, 2)
        };
        assert_eq!(of([1.0, 1.5]), [1.0; 4]);
        assert_eq!(of([3.0, 3.0]), [0.0, 0.0, 0.0, 1.0]);
        // Where all of one and nothing of the other is predicted, 0.9 and 0.1 with what the whole face counts.
        let found = of([0.0, 4.0]);
        assert_eq!([found[0], found[1], found[3]], [1.0, 0.0, 1.0]);
        assert!((found[2] - 0.5).abs() < 1e-12, "{found:?}");
        // 1 − 2.2/4 is half way from 0.4 to 0.5.
        let found = of([2.2, 2.2]);
        assert!((found[2] - 0.5).abs() < 1e-9, "{found:?}");
        assert_eq!(trust(&[], &influences, &listens, 2, 2), [1.0; 4]);
    }
}
