//! The window's colours, in a light and a dark theme.

use eframe::egui::{self, Color32, Theme, Visuals};

/// The colour of what is selected or moved: a marker, a play head. It is never that of a text.
pub(crate) const MARKED: Color32 = Color32::from_rgb(235, 120, 20);

/// The size of small letters, in points.
const SMALL: f32 = 11.0;

/// Sets the colours of both themes. Every text has a contrast of at least 4.5 : 1 to its ground.
pub(crate) fn set(context: &egui::Context) {
    for theme in [Theme::Dark, Theme::Light] {
        context.style_mut_of(theme, |style| {
            legible(&mut style.visuals);
            style.text_styles.insert(egui::TextStyle::Small, egui::FontId::proportional(SMALL));
        });
    }
}

/// egui's own colours, where they are legible. The others have other lightnesses.
fn legible(visuals: &mut Visuals) {
    let is_dark = visuals.dark_mode;
    let pick = |dark: Color32, light: Color32| if is_dark { dark } else { light };
    visuals.weak_text_color = Some(pick(Color32::from_gray(165), Color32::from_gray(95)));
    visuals.error_fg_color = pick(Color32::from_rgb(255, 120, 110), Color32::from_rgb(176, 0, 0));
    visuals.warn_fg_color = pick(Color32::from_rgb(255, 170, 60), Color32::from_rgb(130, 75, 0));
    visuals.hyperlink_color = pick(Color32::from_rgb(90, 170, 255), Color32::from_rgb(0, 90, 190));
    visuals.widgets.noninteractive.fg_stroke.color = pick(Color32::from_gray(190), Color32::from_gray(50));
    visuals.widgets.inactive.fg_stroke.color = pick(Color32::from_gray(215), Color32::from_gray(40));
    visuals.selection.bg_fill = pick(Color32::from_rgb(0, 92, 128), Color32::from_rgb(144, 209, 255));
    visuals.selection.stroke.color = pick(Color32::WHITE, Color32::from_rgb(0, 50, 75));
}

/// The ground of words over a picture, which may have any colour. It lets a little of the picture through.
pub(crate) fn over_picture(visuals: &Visuals) -> Color32 {
    visuals.extreme_bg_color.gamma_multiply(0.7)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least contrast of text by WCAG 2.1, level AA.
    const LEAST: f64 = 4.5;

    /// Relative luminance, as WCAG 2.1 defines it for sRGB.
    fn luminance(colour: Color32) -> f64 {
        let linear = |byte: u8| {
            let c = f64::from(byte) / 255.0;
            if c <= 0.03928 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
    }

    fn contrast(a: Color32, b: Color32) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    /// A colour with premultiplied opacity over an opaque one, as the window blends them.
    fn over(colour: Color32, ground: Color32) -> Color32 {
        let rest = 1.0 - f32::from(colour.a()) / 255.0;
        let mix = |c: u8, g: u8| (f32::from(c) + rest * f32::from(g)).round().min(255.0) as u8;
        Color32::from_rgb(
            mix(colour.r(), ground.r()),
            mix(colour.g(), ground.g()),
            mix(colour.b(), ground.b()),
        )
    }

    /// Each text with its ground, named.
    fn pairs(visuals: &Visuals) -> Vec<(String, Color32, Color32)> {
        let mut pairs = Vec::new();
        let panel = visuals.panel_fill;
        let striped = over(visuals.faint_bg_color, panel);
        let grounds = [
            ("panel", panel),
            ("striped", striped),
            ("window", visuals.window_fill),
            ("field", visuals.extreme_bg_color),
        ];
        let texts = [
            ("text", visuals.text_color()),
            ("weak", visuals.weak_text_color()),
            ("strong", visuals.strong_text_color()),
            ("link", visuals.hyperlink_color),
            ("error", visuals.error_fg_color),
            ("warning", visuals.warn_fg_color),
        ];
        for (ground, behind) in grounds {
            for (text, colour) in texts {
                pairs.push((format!("{text} on {ground}"), over(colour, behind), behind));
            }
        }
        let widgets = &visuals.widgets;
        let states = [
            ("inactive", &widgets.inactive),
            ("hovered", &widgets.hovered),
            ("active", &widgets.active),
            ("open", &widgets.open),
        ];
        for (state, widget) in states {
            for fill in [widget.bg_fill, widget.weak_bg_fill] {
                let behind = over(fill, panel);
                pairs.push((format!("{state} button"), over(widget.text_color(), behind), behind));
            }
        }
        let selected = over(visuals.selection.bg_fill, panel);
        pairs.push(("selected".to_owned(), over(visuals.selection.stroke.color, selected), selected));
        for picture in [Color32::BLACK, Color32::WHITE, Color32::GRAY] {
            let behind = over(over_picture(visuals), picture);
            pairs.push(("legend".to_owned(), over(visuals.strong_text_color(), behind), behind));
        }
        pairs
    }

    #[test]
    fn the_measure_is_that_of_the_standard() {
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-9);
        // The example of many guides: this grey on white just fails, and the next darker one passes.
        assert!(contrast(Color32::from_gray(0x77), Color32::WHITE) < LEAST);
        assert!(contrast(Color32::from_gray(0x76), Color32::WHITE) > LEAST);
    }

    #[test]
    fn every_text_is_legible_in_both_themes() {
        let context = egui::Context::default();
        set(&context);
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = context.style_of(theme).visuals.clone();
            let pairs = pairs(&visuals);
            assert!(pairs.len() > 30);
            for (what, text, ground) in pairs {
                let found = contrast(text, ground);
                assert!(found >= LEAST, "{theme:?}, {what}: {found:.2} : 1 ({text:?} on {ground:?})");
            }
        }
        // egui's own themes fail, so the test can tell.
        let fails = |visuals: Visuals| pairs(&visuals).iter().any(|(_, a, b)| contrast(*a, *b) < LEAST);
        assert!(fails(Visuals::dark()) && fails(Visuals::light()));
    }
}
