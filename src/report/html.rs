//! The report as one page of HTML, with its pictures inside.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd, html};

/// The page of `markdown`, whose pictures are the files in `pictures`: SVG as it is, PNG encoded.
pub(crate) fn page(title: &str, markdown: &str, pictures: &[(String, Vec<u8>)]) -> String {
    let inside = |name: &str| {
        let (_, data) = pictures.iter().find(|(known, _)| known == name)?;
        Some(match name.ends_with(".svg") {
            true => format!("<figure>{}</figure>", String::from_utf8_lossy(data)),
            false => format!(
                "<figure><img alt=\"\" src=\"data:image/png;base64,{}\"></figure>",
                STANDARD.encode(data)
            ),
        })
    };
    // The page has no markup but its own: what else looks like some is text, and nothing leads out of it.
    let own = |event| match event {
        Event::Start(Tag::Image { dest_url, .. }) => {
            inside(&dest_url).map(|picture| Event::Html(picture.into()))
        }
        Event::Html(text) | Event::InlineHtml(text) => Some(Event::Text(text)),
        Event::Start(Tag::Link { .. }) | Event::End(TagEnd::Link | TagEnd::Image) => None,
        other => Some(other),
    };
    let events = Parser::new_ext(markdown, Options::ENABLE_TABLES).filter_map(own);
    let mut body = String::new();
    html::push_html(&mut body, events);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{POLICY}\n<title>{}</title>\n<style>{STYLE}</style>\n\
         </head>\n<body>\n{body}</body>\n</html>\n",
        title.replace('&', "&amp;").replace('<', "&lt;")
    )
}

/// Allows browsers nothing but what is in the page.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; \
    img-src data:\">";

const STYLE: &str = "
body { font: 15px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2rem; }
figure { margin: 1rem 0; } figure svg, figure img { max-width: 100%; height: auto; }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums; display: block; overflow-x: auto; }
th, td { border-bottom: 1px solid #ddd; padding: .2rem .6rem; text-align: left; white-space: nowrap; }
code { background: #f3f3f3; padding: 0 .2rem; }
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_our_own_markup_passes() {
        let pictures = [("a.svg".to_string(), b"<svg></svg>".to_vec())];
        let markdown = "![ours](a.svg) ![theirs](http://b/c.png) [link](javascript:alert(1)) <b>bold</b>\n\n<script>\nx\n</script>\n\n\
            <http://auto>\n";
        let page = page("<i>&amp;", markdown, &pictures);
        let body = page.split("<body>\n").nth(1).unwrap();
        assert_eq!(
            body,
            "<p><figure><svg></svg></figure>ours theirs link &lt;b&gt;bold&lt;/b&gt;</p>\n&lt;script&gt;\nx\n&lt;/script&gt;\n\
             <p>http://auto</p>\n</body>\n</html>\n"
        );
        assert!(page.contains("<title>&lt;i>&amp;amp;</title>"));
    }
}
