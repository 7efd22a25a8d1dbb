//! Rust source as tokens, without its tests.

/// Returns the identifiers and the punctuation of a source without its comments, literals and items
/// under `#[cfg(test)]`. `::` is one token, and so is `=>`; all other punctuation is single characters.
pub(super) fn tokens(source: &str) -> Vec<&str> {
    without_tests(all_tokens(source))
}

fn all_tokens(source: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let length = if first.is_whitespace() {
            first.len_utf8()
        } else if let Some(length) = ignored(rest) {
            length
        } else {
            let length = if is_word(first) {
                rest.find(|c| !is_word(c)).unwrap_or(rest.len())
            } else if rest.starts_with("::") || rest.starts_with("=>") {
                2
            } else {
                first.len_utf8()
            };
            tokens.push(&rest[..length]);
            length
        };
        rest = &rest[length..];
    }
    tokens
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Returns the length of a comment, a literal or a lifetime at the beginning of a source.
fn ignored(source: &str) -> Option<usize> {
    let end = |from: usize, end: &str| {
        let found = source[from..].find(end);
        found.map_or(source.len(), |at| from + at + end.len())
    };
    if source.starts_with("//") {
        return Some(end(0, "\n"));
    }
    if source.starts_with("/*") {
        return Some(end(2, "*/"));
    }
    let prefix = source.len() - source.trim_start_matches(['b', 'c', 'r']).len();
    let raw = source[..prefix].contains('r');
    let hashes = source[prefix..].len() - source[prefix..].trim_start_matches('#').len();
    if raw && source[prefix + hashes..].starts_with('"') {
        let closing = format!("\"{}", "#".repeat(hashes));
        return Some(end(prefix + hashes + 1, &closing));
    }
    if prefix <= 2 && source[prefix..].starts_with('"') {
        return Some(prefix + quoted(&source[prefix..]));
    }
    let mut chars = source.chars();
    if prefix > 1 || chars.nth(prefix) != Some('\'') {
        return None;
    }
    let (first, second) = (chars.next()?, chars.next()?);
    let literal = &source[prefix..];
    Some(if first == '\\' || second == '\'' {
        prefix + quoted(literal)
    } else {
        let name = &literal[1..];
        1 + name.find(|c| !is_word(c)).unwrap_or(name.len())
    })
}

/// Returns the length of a literal in quotes of the kind with which the source begins.
fn quoted(source: &str) -> usize {
    let mut escaped = false;
    let quote = source.as_bytes()[0];
    for (i, byte) in source.bytes().enumerate().skip(1) {
        if byte == quote && !escaped {
            return i + 1;
        }
        escaped = byte == b'\\' && !escaped;
    }
    source.len()
}

fn without_tests(tokens: Vec<&str>) -> Vec<&str> {
    let mut kept = Vec::with_capacity(tokens.len());
    let mut rest = tokens.as_slice();
    while let Some((first, after)) = rest.split_first() {
        if let ["#", "[", "cfg", "(", ..] = rest
            && let Some(end) = rest.iter().position(|token| *token == "]")
            && rest[..end].contains(&"test")
        {
            rest = after_item(&rest[end + 1..]);
        } else {
            kept.push(*first);
            rest = after;
        }
    }
    kept
}

/// Returns the tokens after the first item.
fn after_item<'a, 'b>(tokens: &'b [&'a str]) -> &'b [&'a str] {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate() {
        match *token {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
        let ended = *token == ";" || (*token == "}" && tokens[0] != "use");
        if depth == 0 && ended {
            return &tokens[i + 1..];
        }
    }
    &[]
}
