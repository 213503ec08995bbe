//! Switches for optional features with settings of their own.

choices! {
    /// The two positions of a switch.
    pub(super) enum OnOff {
        /// The feature is drawn.
        On = "on",
        /// The feature is left out.
        Off = "off",
    }
}

/// The row that switches a parameter struct, and the rows of an `Option` of it: when off, its settings are validated
/// and dropped.
macro_rules! on_or_off {
    (
        $(#[doc = $why:literal])*
        $of:ident as $name:ident in $group:ident, flag: $flag:literal, doc: [$($doc:literal)*]
    ) => {
        $(#[doc = $why])*
        const _: () = {
            use crate::error::Result;
            use crate::params::line::on_off::OnOff;
            use crate::params::value::Value;
            use crate::params::{Param, Parameters};

            params!(@row $group $name [$($doc)*] OnOff = OnOff::On, flag: $flag, common: true, form: "on|off");

            impl Parameters for Option<$of> {
                fn usual() -> Self {
                    Some($of::default())
                }

                fn rows(table: &mut Vec<&'static Param>) {
                    table.push(&$name);
                    $of::rows(table);
                }

                fn set(&mut self, name: &str, text: &str) -> std::result::Result<bool, String> {
                    if name != $name.name() {
                        let mut own = self.unwrap_or_default();
                        let is_own = own.set(name, text)?;
                        *self = self.map(|_| own);
                        return Ok(is_own);
                    }
                    *self = match OnOff::parse(text, &$name)? {
                        OnOff::On => self.or(Self::usual()),
                        OnOff::Off => None,
                    };
                    Ok(true)
                }

                fn check(&self) -> Result<()> {
                    self.as_ref().map_or(Ok(()), $of::check)
                }
            }
        };
    };
}
