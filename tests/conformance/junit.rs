//! JUnit's XML read strictly, and the rules of Jenkins' `junit-10.xsd` for it: which elements are in which, and their
//! attributes.

use std::collections::BTreeMap;

/// An element, without its text.
#[derive(Debug, Default)]
pub struct Element {
    pub name: String,
    pub attributes: BTreeMap<String, String>,
    pub children: Vec<Element>,
    pub text: String,
}

impl Element {
    pub fn number(&self, attribute: &str) -> f64 {
        self.attributes.get(attribute).and_then(|value| value.parse().ok()).unwrap_or(f64::NAN)
    }

    /// All elements of that name below this one.
    pub fn all(&self, name: &str) -> Vec<&Element> {
        let below = self.children.iter().flat_map(|child| child.all(name));
        self.children.iter().filter(|child| child.name == name).chain(below).collect()
    }
}

/// Reads a document of elements, attributes in double quotes, and text.
pub fn parse(text: &str) -> Result<Element, String> {
    let mut rest = text.strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>").ok_or("no declaration")?;
    let mut open: Vec<Element> = vec![Element::default()];
    while let Some(start) = rest.find('<') {
        let here = open.last_mut().ok_or("an end without a beginning")?;
        here.text.push_str(&plain(&rest[..start])?);
        let end = start + rest[start..].find('>').ok_or("a tag does not end")?;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            let element = open.pop().filter(|element| element.name == name).ok_or(format!("</{name}> ends nothing"))?;
            open.last_mut().ok_or("nothing around it")?.children.push(element);
            continue;
        }
        let (tag, is_empty) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
        let element = element(tag)?;
        if is_empty {
            open.last_mut().ok_or("nothing around it")?.children.push(element);
        } else {
            open.push(element);
        }
    }
    match (open.len(), open.pop().map(|mut document| document.children.split_off(0))) {
        (1, Some(mut roots)) if roots.len() == 1 && rest.trim().is_empty() => Ok(roots.remove(0)),
        _ => Err("elements do not end, or there is more than one around all".to_string()),
    }
}

fn element(tag: &str) -> Result<Element, String> {
    let (name, mut rest) = tag.split_once(' ').unwrap_or((tag, ""));
    let mut element = Element { name: name.to_string(), ..Default::default() };
    while !rest.trim().is_empty() {
        let (key, after) = rest.trim_start().split_once("=\"").ok_or(format!("no attribute in {rest}"))?;
        let (value, after) = after.split_once('"').ok_or(format!("{key} does not end"))?;
        if element.attributes.insert(key.to_string(), plain(value)?).is_some() {
            return Err(format!("{key} is there twice"));
        }
        rest = after;
    }
    Ok(element)
}

fn plain(text: &str) -> Result<String, String> {
    let mut parts = text.split('&');
    let mut plain = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (name, after) = part.split_once(';').ok_or(format!("a bare & in {text}"))?;
        plain.push(match name {
            "amp" => '&',
            "lt" => '<',
            "gt" => '>',
            "quot" => '"',
            _ => return Err(format!("&{name}; is not known")),
        });
        plain.push_str(after);
    }
    Ok(plain)
}

/// Of an element: attributes that it must have, those that it may have, and what may be in it.
type Rule = (&'static [&'static str], &'static [&'static str], &'static [&'static str]);

fn rule(name: &str) -> Option<Rule> {
    Some(match name {
        "testsuites" => (&[], &["name", "time", "tests", "failures", "errors"], &["testsuite"]),
        "testsuite" => (
            &["name", "tests", "failures", "errors"],
            &["group", "time", "skipped", "timestamp", "hostname", "id", "package", "file", "log", "url"],
            &["properties", "testcase", "testsuite", "system-out", "system-err"],
        ),
        "properties" => (&[], &[], &["property"]),
        "property" => (&["name", "value"], &[], &[]),
        "testcase" => {
            (&["name"], &["time", "classname", "group"], &["skipped", "error", "failure", "system-out", "system-err"])
        }
        "failure" | "error" | "skipped" => (&[], &["type", "message"], &[]),
        "system-out" | "system-err" => (&[], &[], &[]),
        _ => return None,
    })
}

/// What the schema does not allow.
pub fn errors(element: &Element) -> Vec<String> {
    let Some((needed, allowed, inside)) = rule(&element.name) else {
        return vec![format!("there is no element {}", element.name)];
    };
    let mut found = Vec::new();
    let name = &element.name;
    found.extend(
        needed.iter().filter(|key| !element.attributes.contains_key(**key)).map(|key| format!("{name} has no {key}")),
    );
    let known = |key: &str| needed.contains(&key) || allowed.contains(&key);
    found.extend(element.attributes.keys().filter(|key| !known(key)).map(|key| format!("{name} has {key}")));
    for key in ["tests", "failures", "errors", "skipped", "time"] {
        let number = element.attributes.get(key).map(|value| value.parse::<f64>());
        if element.name != "testcase" && number.is_some_and(|number| !number.is_ok_and(|n| n >= 0.0)) {
            found.push(format!("{name}'s {key} is no number"));
        }
    }
    let misplaced = element.children.iter().filter(|child| !inside.contains(&child.name.as_str()));
    found.extend(misplaced.map(|child| format!("{} in {name}", child.name)));
    found.extend(element.children.iter().flat_map(errors));
    found
}
