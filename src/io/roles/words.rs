//! The words of a layer's name, for names that are in no table.
//!
//! A name is split at punctuation, changes of case and digits, and unknown remainders into words of the table:
//! `VRayNormals`, `geo_n_world` and `camN.001` all hold a word for normals, with qualifying words. The words of the
//! last meaningful piece count: the prefix does not make `ViewLayer.camN` view space. A word with another meaning
//! excludes: `normal_strength`, `rayDepth`, `crypto_object`.
//!
//! To add a word, add it to [`WORDS`].

use super::names::Role;
use crate::frame::NormalSpace;
use std::collections::HashMap;
use std::sync::LazyLock;

/// Meaning of a word in a layer's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WordMeaning {
    /// The role that the layer plays.
    Plays(Role),
    /// The same, if all other words are known: short words have many meanings.
    MayPlay(Role),
    /// The space of vectors.
    Space(NormalSpace),
    /// Preference of the layer, smaller is better; 0 for words without meaning.
    Goes(u8),
    /// The layer plays none of the roles of this table.
    Excludes,
}

use WordMeaning::{Excludes, Goes, MayPlay, Plays, Space};

/// Meanings of words in lower case; two adjacent words, such as `base color`, are first looked up as one.
const WORDS: &[(WordMeaning, &str)] = &[
    (Plays(Role::Normal), "normal normals nrm nrml nml norm nor"),
    (MayPlay(Role::Normal), "n ns ng nn"),
    (
        Plays(Role::Position),
        "position positions pos worldpoint worldpoints",
    ),
    (MayPlay(Role::Position), "p point points"),
    (
        Plays(Role::Depth),
        "depth zdepth zbuffer zbuf depthz disparity inversedepth invdepth",
    ),
    (MayPlay(Role::Depth), "z pz"),
    (MayPlay(Role::Motion), "backward motion"),
    (
        Plays(Role::Albedo),
        "albedo basecolor basecolour diffusealbedo diffusefilter",
    ),
    (MayPlay(Role::Occlusion), "ao ambientocclusion"),
    (MayPlay(Role::Color), "beauty rgba combined"),
    (Space(NormalSpace::World), "world ws wld"),
    (Space(NormalSpace::View), "camera cam view eye cs"),
    (
        Goes(0),
        "space shading shaded sh bump bumped smooth smoothed surface map pass aov aovs layer lyr render element \
         channel buffer output out extra final raw linear normalized normalised filtered unfiltered full main master \
         scene v ver rs redshift ai arnold vray vr vre mtl material octane oct karma mantra houdini hou rman \
         renderman prman corona cycles eevee blender maxwell rayhit lpe util utility data tech",
    ),
    (Goes(1), "geo geom geometry geometric face facet flat"),
    (Goes(2), "denoise denoising denoiser oidn"),
    (
        Excludes,
        "id ids index crypto cryptomatte mask masks matte mattes key alpha weight weights strength intensity amount \
         variance error noise samples count raydepth bounce hit reflect reflected reflection reflections refl refract \
         refracted refraction refr diffuse specular spec glossy coat sheen transmission sss subsurface volume \
         emission light lights lgt shadow shadows ref pref nref rest tangent tangents binormal bitangent object obj \
         local uv st dof field fog mist facing fresnel curvature forward velocity environment background",
    ),
];

/// Meaning of a layer's name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Said {
    /// The words that count; unknown ones are left as they are.
    pub(crate) words: Vec<String>,
    /// The role, where exactly one is meant.
    pub(crate) role: Option<Role>,
    /// The space that vectors are in.
    pub(crate) space: Option<NormalSpace>,
    /// Whether a word excludes all roles that words can give.
    pub(crate) is_excluded: bool,
    /// The rank among layers of one role, the least first: words that are not known, then how well the layer serves.
    pub(crate) rank: (usize, u8),
}

/// Meaning of the words of `name`, ignoring the `view` of a stereo file.
pub(crate) fn said(name: &str, view: Option<&str>) -> Said {
    let is_view = |piece: &&str| view.is_some_and(|view| piece.eq_ignore_ascii_case(view));
    let mut words = Vec::new();
    for piece in name.rsplit('.').filter(|piece| !is_view(piece)) {
        let mut of_piece = words_of(piece);
        let plays = |word: &String| matches!(meaning(word), Some(Plays(_) | MayPlay(_)));
        let any_plays = of_piece.iter().any(plays);
        of_piece.append(&mut words);
        words = of_piece;
        if any_plays {
            break;
        }
    }
    judge(words)
}

fn judge(words: Vec<String>) -> Said {
    let meanings: Vec<_> = words.iter().map(|word| meaning(word)).collect();
    let unknown = meanings.iter().filter(|m| m.is_none()).count();
    let known = || meanings.iter().flatten();
    let is_excluded = known().any(|m| *m == Excludes);
    let mut roles: Vec<Role> = known()
        .filter_map(|meaning| match meaning {
            Plays(role) => Some(*role),
            MayPlay(role) if unknown == 0 => Some(*role),
            _ => None,
        })
        .collect();
    roles.dedup();
    let mut spaces = known().filter_map(|meaning| match meaning {
        Space(space) => Some(*space),
        _ => None,
    });
    let worst = known().map(|m| if let Goes(rank) = m { *rank } else { 0 });
    Said {
        role: match roles[..] {
            [role] if !is_excluded => Some(role),
            _ => None,
        },
        space: spaces.next().filter(|first| spaces.all(|s| s == *first)),
        is_excluded,
        rank: (unknown, worst.max().unwrap_or(0)),
        words,
    }
}

fn meaning(word: &str) -> Option<WordMeaning> {
    static MEANINGS: LazyLock<HashMap<&str, WordMeaning>> = LazyLock::new(|| {
        let rows = WORDS.iter();
        let words =
            rows.flat_map(|(meaning, words)| words.split_whitespace().map(|word| (word, *meaning)));
        words.collect()
    });
    MEANINGS.get(word).copied()
}

/// The words of one piece of a name, in lower case. Numbers have no meaning, but stay attached to a letter before them:
/// `P1` is not `P`.
fn words_of(piece: &str) -> Vec<String> {
    let split = split(piece);
    let mut words = Vec::new();
    let mut rest = &split[..];
    while let Some(first) = rest.first() {
        // The longest run that is known as one word: v, ray, depth are vray and depth.
        let runs = (2..=rest.len().min(3)).rev();
        let mut known = runs.map(|n| (n, rest[..n].concat()));
        let known = known.find(|(_, run)| meaning(run).is_some());
        let (taken, run) = match known {
            Some((n, run)) => (n, vec![run]),
            None => (1, known_words(first).unwrap_or_else(|| vec![first.clone()])),
        };
        words.extend(run);
        rest = &rest[taken..];
    }
    words
}

/// A piece split at punctuation, digits and changes of case.
fn split(piece: &str) -> Vec<String> {
    let letters: Vec<char> = piece.chars().collect();
    let mut words: Vec<String> = Vec::new();
    let mut open = false;
    for (i, &c) in letters.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| letters[i]);
        let after = letters.get(i + 1);
        if c.is_ascii_digit() {
            let glued = before.is_some_and(char::is_alphabetic);
            let word = words
                .last_mut()
                .filter(|word| glued && open && word.len() == 1);
            if let Some(word) = word.filter(|word| *word != "v") {
                word.push(c);
            }
            open = false;
        } else if c.is_alphabetic() {
            let begins = c.is_uppercase()
                && (before.is_some_and(char::is_lowercase)
                    || before.is_some_and(char::is_uppercase)
                        && after.is_some_and(|c| c.is_lowercase()));
            if begins || !open {
                words.push(String::new());
            }
            open = true;
            if let Some(word) = words.last_mut() {
                word.extend(c.to_lowercase());
            }
        } else {
            open = false;
        }
    }
    words
}

/// Longest word to be split; longer ones are not renderers' names.
const LONGEST: usize = 48;

/// The fewest words of the table that `text`, in lower case, consists of; `None` if something is left over. One-letter
/// words are first or last, beside one of three or more.
fn known_words(text: &str) -> Option<Vec<String>> {
    if !text.is_ascii() || text.len() > LONGEST {
        return None;
    }
    // The fewest words that each beginning of the text is made of.
    let mut fewest: Vec<Option<Vec<&str>>> = vec![None; text.len() + 1];
    fewest[0] = Some(Vec::new());
    for end in 1..=text.len() {
        for start in 0..end {
            let Some(begin) = &fewest[start] else {
                continue;
            };
            let word = &text[start..end];
            let at_end = start == 0 || end == text.len();
            if word.len() == 1 && !at_end || meaning(word).is_none() {
                continue;
            }
            let is_fewer = fewest[end]
                .as_ref()
                .is_none_or(|f| begin.len() + 1 < f.len());
            if is_fewer {
                fewest[end] = Some(begin.iter().copied().chain([word]).collect());
            }
        }
    }
    let words = fewest.pop().flatten()?;
    let short = words.iter().any(|word| word.len() == 1);
    let long = words.iter().any(|word| word.len() > 2);
    (words.len() == 1 || long || !short).then(|| words.into_iter().map(Into::into).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fall_into_words() {
        let words = |name| said(name, None).words.join(" ");
        for (name, expected) in [
            ("N_camera", "n camera"),
            ("camN", "cam n"),
            ("camn", "cam n"),
            ("VRayNormals", "vray normals"),
            ("vraynormals", "vray normals"),
            ("geoNWorld", "geo n world"),
            ("AOVNormal.001", "aov normal"),
            ("ViewLayer.rs_normal_v2", "rs normal v"),
            ("VRayZDepth", "vray zdepth"),
            ("rayDepth", "raydepth"),
            ("P1", "p1"),
            ("north", "north"),
        ] {
            assert_eq!(words(name), expected, "{name}");
        }
    }

    #[test]
    fn words_give_roles_and_words_take_them() {
        let role = |name| said(name, None).role;
        for (name, expected) in [
            ("hero_normal", Some(Role::Normal)),
            // A letter means it only beside words that are known.
            ("hero_n", None),
            ("P_world", Some(Role::Position)),
            ("P_ref", None),
            ("P1", None),
            ("normal_strength", None),
            ("rayDepth", None),
            ("normal_depth", None),
            ("diffuse_depth", None),
            ("HitNormal", None),
            ("RGBA_key", None),
            ("mtl_baseColor", Some(Role::Albedo)),
            ("depth.v2", Some(Role::Depth)),
            ("", None),
        ] {
            assert_eq!(role(name), expected, "{name}");
        }
        assert_eq!(said("N_camera", None).space, Some(NormalSpace::View));
        assert_eq!(said("ViewLayer.n_v2", None).space, None);
        assert!(said("normal", None).rank < said("normal_geo", None).rank);
    }
}
