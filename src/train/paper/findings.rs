//! What the paper found, and whether it holds on the light fields at hand.

use std::collections::BTreeMap;

use serde::Serialize;

use super::judge::{BARS, BLEND, COPY, Figures, HISTOGRAM_PX, Judged, LAMBERTIAN, MEASURED, SWEPT};
use super::method::Method;

/// Bars of the histogram of L1, and how wide each is.
pub const L1_BARS: usize = 20;
pub const L1_BAR: f32 = 0.005;

/// One statement of the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Its figure here.
    pub figure: &'static str,
    /// What the paper says.
    pub paper: &'static str,
    /// What was found here.
    pub here: String,
    /// Whether that is the same; none where a method is missing.
    pub holds: Option<bool>,
}

/// Means over light fields, histograms, and what they say.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// By method: the mean of each figure.
    pub mean: BTreeMap<&'static str, Figures>,
    /// By method: light fields by the L1 of their outermost views, bars of 0.005.
    pub outermost_histogram: BTreeMap<&'static str, Vec<u32>>,
    /// Share of all rays of ours by disparity across the whole aperture, −8 … 8 px.
    pub disparities: Vec<f64>,
    /// The paper's statements.
    pub findings: Vec<Finding>,
}

impl Found {
    /// From what was found on each light field.
    pub fn of(judged: &[Judged]) -> Self {
        let names: Vec<&'static str> =
            judged.first().map_or_else(Vec::new, |one| one.figures.keys().copied().collect());
        let of = |name: &str| judged.iter().filter_map(|one| one.figures.get(name)).collect::<Vec<_>>();
        let mean: BTreeMap<_, _> = names.iter().filter_map(|name| Some((*name, mean_of(&of(name))?))).collect();
        let outermost_histogram = names.iter().map(|name| (*name, histogram(&of(name)))).collect();
        let mut counts = [0; BARS];
        for one in judged.iter().filter_map(|one| one.disparities.as_ref()) {
            counts.iter_mut().zip(one).for_each(|(sum, n)| *sum += n);
        }
        let all = counts.iter().sum::<u64>().max(1) as f64;
        let disparities: Vec<f64> = counts.iter().map(|n| (*n as f64 / all * 1e6).round() / 1e6).collect();
        let findings = findings(&mean, &disparities, judged.len());
        Self { mean, outermost_histogram, disparities, findings }
    }
}

fn mean_of(all: &[&Figures]) -> Option<Figures> {
    let mean = |of: &dyn Fn(&Figures) -> f32| all.iter().map(|f| of(f)).sum::<f32>() / all.len() as f32;
    let known = |of: &dyn Fn(&Figures) -> Option<f32>| {
        let values: Option<Vec<f32>> = all.iter().map(|f| of(f)).collect();
        values.map(|values| values.iter().sum::<f32>() / values.len() as f32)
    };
    let first = all.first()?;
    Some(Figures {
        l1: mean(&|f| f.l1),
        outermost_l1: mean(&|f| f.outermost_l1),
        l1_by_u: (0..first.l1_by_u.len()).map(|u| mean(&|f| f.l1_by_u[u])).collect(),
        unseen_l1: mean(&|f| f.unseen_l1),
        inconsistency_px: known(&|f| f.inconsistency_px),
        depth_correlation: known(&|f| f.depth_correlation),
    })
}

fn histogram(all: &[&Figures]) -> Vec<u32> {
    let mut bars = vec![0; L1_BARS];
    for figures in all {
        bars[((figures.outermost_l1 / L1_BAR) as usize).min(L1_BARS - 1)] += 1;
    }
    bars
}

/// Names and values in the order that the paper expects, and whether they are in it.
fn ordered(values: &[(&str, Option<f32>)]) -> (String, Option<bool>) {
    let told: Vec<String> =
        values.iter().map(|(name, v)| v.map_or_else(|| format!("{name} –"), |v| format!("{name} {v:.4}"))).collect();
    let known: Option<Vec<f32>> = values.iter().map(|(_, v)| *v).collect();
    (told.join(", "), known.map(|v| v.windows(2).all(|pair| pair[0] < pair[1])))
}

/// Two values in the order that the paper expects, beside others that it does not speak of.
fn first_two(values: [(&str, Option<f32>); 2], beside: &[(&str, Option<f32>)]) -> (String, Option<bool>) {
    let (told, holds) = ordered(&values);
    (format!("{told}; beside them {}", ordered(beside).0), holds)
}

fn findings(mean: &BTreeMap<&'static str, Figures>, disparities: &[f64], count: usize) -> Vec<Finding> {
    let of = |name: &str, figure: &dyn Fn(&Figures) -> Option<f32>| mean.get(name).and_then(figure);
    let [ours, flow, regression] = [Method::Ours, Method::Flow, Method::Regression].map(Method::name);
    let l1 = |f: &Figures| Some(f.l1);
    let outermost = |f: &Figures| Some(f.outermost_l1);
    let spread = |f: &Figures| f.inconsistency_px;
    let [without, neither] = [Method::NoConsistency, Method::NoRegularisers].map(Method::name);
    let mut found = Vec::new();
    let mut say = |figure, paper, (here, holds): (String, Option<bool>)| {
        found.push(Finding { figure, paper, here: format!("{here}; {count} light fields"), holds });
    };
    say(
        "mean-l1",
        "mean L1 over all views: ours 0.026, direct regression 0.031",
        ordered(&[("ours", of(ours, &l1)), ("regression", of(regression, &l1))]),
    );
    say(
        "outermost-l1",
        "on the outermost views ours < Lambertian < appearance flow",
        ordered(&[
            ("ours", of(ours, &outermost)),
            ("Lambertian", of(LAMBERTIAN, &outermost)),
            ("flow", of(flow, &outermost)),
        ]),
    );
    say(
        "l1-by-u",
        "all methods are best near the input view, and ours below flow everywhere",
        by_u(mean, [ours, flow]),
    );
    let unseen = |name: &str| of(name, &|f| Some(f.unseen_l1));
    let [photo, corners] = [ours, Method::Corners.name()].map(unseen);
    let beside = [
        ("the corners blended", unseen(BLEND)),
        ("warped by the depth swept over them", unseen(SWEPT)),
        ("the photo warped by the depth of all views", unseen(MEASURED)),
    ];
    say(
        "unseen-l1",
        "on views that neither is given 0.0176, against 0.0145 of a method that is given the four corners",
        first_two([("given the corners", corners), ("ours", photo)], &beside),
    );
    let agrees = of(ours, &|f| f.depth_correlation);
    let told = agrees.map_or_else(|| "not trained".to_owned(), |c| format!("their correlation is {c:.2}"));
    say(
        "depths",
        "ray depths from the photo alone compare with those measured from the whole light field",
        (told, None),
    );
    say(
        "ablation",
        "ψ_c makes ray depths agree along epipolar lines",
        first_two(
            [("mean difference along them, px: ours", of(ours, &spread)), ("without ψ_c", of(without, &spread))],
            &[("without ψ_c and ψ_tv", of(neither, &spread))],
        ),
    );
    let behind: f64 = disparities[..BARS / 2].iter().sum();
    let told = if agrees.is_some() {
        format!("{:.0} % of the rays lie behind the focal plane", 100.0 * behind)
    } else {
        "not trained".to_owned()
    };
    say(
        "disparities",
        "disparities across the aperture have two peaks: backgrounds far below 0, subjects near it",
        (told, None),
    );
    let copy = of(COPY, &l1);
    say(
        "better-than-a-copy",
        "(not in the paper) a net that has learned something beats the photo copied to all views",
        ordered(&[("ours", of(ours, &l1)), ("copy", copy)]),
    );
    found
}

/// Whether each falls towards the input view, and the first lies below the second.
fn by_u(mean: &BTreeMap<&'static str, Figures>, names: [&str; 2]) -> (String, Option<bool>) {
    let both: Option<Vec<&Vec<f32>>> = names.iter().map(|name| mean.get(name).map(|f| &f.l1_by_u)).collect();
    let Some(both) = both else { return ("not all are trained".to_owned(), None) };
    let least_at = |values: &[f32]| (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
    let near = both.iter().all(|values| least_at(values).abs_diff(4) <= 1);
    let below = both[0].iter().zip(both[1]).filter(|(ours, flow)| ours < flow).count();
    let told = format!("ours lies below flow at {below} of {} places of u", both[0].len());
    (told, Some(near && below == both[0].len()))
}

/// Names of the bars of the histogram of disparities: its ends, its middle.
pub fn disparity_places() -> Vec<String> {
    let name = |bar: usize| match bar {
        0 => format!("≤ {:.0}", -HISTOGRAM_PX),
        _ if bar == BARS / 2 => "0".to_owned(),
        _ if bar == BARS - 1 => format!("≥ {HISTOGRAM_PX:.0}"),
        _ => String::new(),
    };
    (0..BARS).map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(l1: f32) -> Figures {
        let l1_by_u = [4.0, 3.0, 2.0, 1.0, 0.5, 1.0, 2.0, 3.0].map(|by| by * l1).to_vec();
        let (inconsistency_px, depth_correlation) = (Some(l1), Some(0.5));
        Figures { l1, outermost_l1: 2.0 * l1, l1_by_u, unseen_l1: l1, inconsistency_px, depth_correlation }
    }

    #[test]
    fn each_statement_holds_or_not_or_cannot_be_told() {
        let mut mean = BTreeMap::from([("ours", figures(0.02)), (LAMBERTIAN, figures(0.03)), (COPY, figures(0.01))]);
        let holds = |mean: &BTreeMap<&'static str, Figures>, figure: &str| {
            let found = findings(mean, &[0.0; BARS], 3);
            found.into_iter().find(|f| f.figure == figure).unwrap().holds
        };
        assert_eq!(holds(&mean, "outermost-l1"), None, "flow is not trained");
        assert_eq!(holds(&mean, "better-than-a-copy"), Some(false));
        mean.insert("flow", figures(0.04));
        mean.insert("regression", figures(0.05));
        assert_eq!(holds(&mean, "outermost-l1"), Some(true));
        assert_eq!((holds(&mean, "mean-l1"), holds(&mean, "l1-by-u")), (Some(true), Some(true)));
        mean.insert("flow", figures(0.025));
        assert_eq!(holds(&mean, "outermost-l1"), Some(false), "Lambertian is worse than flow here");
        assert!(findings(&mean, &[0.0; BARS], 3).iter().all(|f| f.here.ends_with("; 3 light fields")));
    }
}
