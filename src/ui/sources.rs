//! The sources of depth that a photo has, as people choose and compare them.

use super::event::Listed;
use super::words::t;
use crate::scene::{DepthFrom, OnePhoto};

/// A source with its name.
pub type Choice = (DepthFrom, String);

/// All that can be used for a photo now: its own depth first, then nets that were added, then the program's own.
pub fn choices(one: &OnePhoto, nets: &[Listed]) -> Vec<Choice> {
    if one.splats.is_some() {
        return vec![(DepthFrom::Auto, t!("source-gaussians").to_owned())];
    }
    let mut all = of_photo(one);
    all.extend(nets.iter().filter(|net| net.fault.is_none()).map(|net| (net.source(), net.name.clone())));
    all.push((DepthFrom::Network, t!("source-network").to_owned()));
    all
}

/// Depth that came with the photo, or was given for it.
pub fn of_photo(one: &OnePhoto) -> Vec<Choice> {
    let mut all = Vec::new();
    // What they tell is the automatic choice.
    all.extend(one.several.as_ref().map(|several| (DepthFrom::Auto, t!("source-photos", count = several.count() + 1))));
    if one.own_map.is_some() {
        all.push((DepthFrom::Map, t!("source-map").to_owned()));
    }
    if one.phone.is_some() {
        all.extend([
            (DepthFrom::Phone, t!("source-phone").to_owned()),
            (DepthFrom::Fused, t!("source-fused").to_owned()),
        ]);
    }
    all
}

/// What a wish comes to: a source that this photo has not is its best one.
pub fn present(wanted: &DepthFrom, one: &OnePhoto, nets: &[Listed]) -> DepthFrom {
    let all = choices(one, nets);
    let same = |(source, _): &&Choice| source == wanted || is_same_net(source, wanted);
    let best = || one.best_source(nets.iter().find(|net| net.is_preferred && net.fault.is_none()).map(Listed::source));
    let wanted_here = all.iter().find(same).or_else(|| all.iter().find(|(source, _)| *source == DepthFrom::Auto));
    wanted_here.map_or_else(best, |(source, _)| source.clone())
}

/// A net may have another name than when it was chosen, or be asked for by its name alone.
fn is_same_net(source: &DepthFrom, wanted: &DepthFrom) -> bool {
    match (source, wanted) {
        (DepthFrom::Net(here), DepthFrom::Net(wanted)) => here.sha256 == wanted.sha256,
        (DepthFrom::Net(here), DepthFrom::Model(name)) => here.id == *name,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::field::{Photo, RelativeDepth};
    use crate::io::{DepthKind, EmbeddedDepth};
    use crate::synth::ModelTag;

    fn net(name: &str, sha256: &str) -> Listed {
        let tag = Some(ModelTag { id: name.to_owned(), sha256: sha256.to_owned() });
        Listed { name: name.to_owned(), tag, fault: None, is_preferred: false, is_added: true }
    }

    fn photo(has_phone: bool) -> OnePhoto {
        let photo = Arc::new(Photo::from_srgb8([2, 1], vec![9; 8]).unwrap());
        let map = RelativeDepth::new([1, 1], vec![1.0]).unwrap();
        let phone = Arc::new(EmbeddedDepth { kind: DepthKind::Gdepth, map, metric: true });
        OnePhoto {
            photo,
            f35_mm: None,
            phone: has_phone.then_some(phone),
            own_map: None,
            splats: None,
            truth: None,
            several: None,
        }
    }

    #[test]
    fn measured_depth_comes_first_and_broken_nets_are_no_choice() {
        let broken = Listed { fault: Some("bad".to_owned()), ..net("broken", "c") };
        let nets = [net("mine", "a"), broken];
        let names = |one: &OnePhoto| choices(one, &nets).into_iter().map(|(_, name)| name).collect::<Vec<_>>();
        assert_eq!(names(&photo(true)), [t!("source-phone"), t!("source-fused"), "mine", t!("source-network")]);
        assert_eq!(names(&photo(false)), ["mine", t!("source-network")]);
    }

    #[test]
    fn a_wish_is_met_under_any_name_or_by_the_best_there_is() {
        let nets = [net("mine", "a"), Listed { is_preferred: true, ..net("other", "b") }];
        let wish = |id: &str, sha256: &str| DepthFrom::Net(ModelTag { id: id.to_owned(), sha256: sha256.to_owned() });
        assert_eq!(present(&wish("old name", "a"), &photo(false), &nets), nets[0].source());
        assert_eq!(present(&wish("mine", "z"), &photo(false), &nets), nets[1].source(), "it is not here");
        assert_eq!(present(&DepthFrom::Phone, &photo(false), &nets), nets[1].source());
        assert_eq!(present(&DepthFrom::Auto, &photo(true), &nets), DepthFrom::Phone);
        assert_eq!(present(&DepthFrom::Model("mine".to_owned()), &photo(true), &nets), nets[0].source());
    }
}
