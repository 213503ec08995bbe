//! Presets: recipes built into the program, one for each kind of subject.

/// The names of presets and their texts.
pub(crate) const PRESETS: [(&str, &str); 9] = [
    ("portrait", include_str!("presets/portrait.toml")),
    ("machine", include_str!("presets/machine.toml")),
    ("architecture", include_str!("presets/architecture.toml")),
    ("drapery", include_str!("presets/drapery.toml")),
    ("inscription", include_str!("presets/inscription.toml")),
    ("coin", include_str!("presets/coin.toml")),
    ("landscape", include_str!("presets/landscape.toml")),
    ("raking", include_str!("presets/raking.toml")),
    (
        "inscription-raking",
        include_str!("presets/inscription-raking.toml"),
    ),
];

/// The preset of a name.
pub(super) fn preset(name: &str) -> Option<&'static str> {
    let found = PRESETS.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text)
}
