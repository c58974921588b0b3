//! A page: one file that needs nothing else.

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// The page as HTML, with a line under its title.
pub(crate) fn document(title: &str, about: &Markup, main: &Markup) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                header {
                    h1 { (title) }
                    p { (about) }
                }
                main { (main) }
            }
        }
    };
    markup.into_string()
}
