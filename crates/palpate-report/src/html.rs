//! Filling the template, and keeping text from becoming markup.

/// Replaces each `{{name}}` of the template in a single pass, so that what is put in is never looked at again.
pub(crate) fn fill(template: &str, value: impl Fn(&str) -> String) -> String {
    let mut page = String::with_capacity(template.len());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        page.push_str(before);
        let Some((name, after)) = after.split_once("}}") else {
            rest = after;
            break;
        };
        page.push_str(&value(name.trim()));
        rest = after;
    }
    page.push_str(rest);
    page
}

/// Text as HTML content or attribute value.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            // Control characters have no place in HTML.
            control if control.is_control() && !control.is_whitespace() => escaped.push('\u{fffd}'),
            other => escaped.push(other),
        }
    }
    escaped
}

/// JSON that is safe inside a `<script>` element: without a `<` nothing in it can end the element.
pub(crate) fn embed(json: &str) -> String {
    json.replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::{embed, escape, fill};

    #[test]
    fn fills_every_placeholder_once() {
        let page = fill("a {{ x }} b {{y}} c", |name| format!("<{name}{{{{x}}}}>"));
        assert_eq!(page, "a <x{{x}}> b <y{{x}}> c");
        assert_eq!(fill("open {{end", |_| unreachable!()), "open end");
    }

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(escape("<b>\"&'\u{7}"), "&lt;b&gt;&quot;&amp;&#39;\u{fffd}");
        assert!(!embed("\"</script>\"").contains('<'));
    }
}
