//! Inertia and friction put into the text of a URDF; every other byte stays.

use crate::{Body, Result, SimError};
use roxmltree::{Document, Node};
use std::ops::Range;

/// Friction and rotor of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dynamics {
    /// Inertia of the rotor as felt at the joint \[kg·m²\], an attribute that most readers pass
    /// over.
    pub armature: f64,
    /// Viscous friction \[N·m·s/rad\].
    pub damping: f64,
    /// Dry friction \[N·m\].
    pub friction: f64,
}

/// The text with new bodies of links, of which one without is taken away, and new friction of joints.
///
/// # Errors
/// [`SimError::Urdf`] if the text is no XML, [`SimError::UnknownJoints`] if it has no
/// link or joint of that name.
pub fn edited(
    text: &str,
    inertials: &[(String, Option<Body>)],
    dynamics: &[(String, Dynamics)],
) -> Result<String> {
    let document = Document::parse(text).map_err(|source| SimError::Urdf { source })?;
    let root = document.root_element();
    let named = |kind: &str, name: &str| {
        let all = || root.children().filter(|node| node.has_tag_name(kind));
        all().find(|node| node.attribute("name") == Some(name)).ok_or_else(|| {
            let known: Vec<&str> = all().filter_map(|node| node.attribute("name")).collect();
            SimError::UnknownJoints { unknown: name.to_owned(), known: known.join(", ") }
        })
    };
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    for (link, body) in inertials {
        let lines = body.as_ref().map(inertial);
        edits.extend(put(text, named("link", link)?, "inertial", lines));
    }
    for (joint, Dynamics { armature, damping, friction }) in dynamics {
        let line = format!(
            "<dynamics damping=\"{damping:?}\" friction=\"{friction:?}\" armature=\"{armature:?}\"/>"
        );
        edits.extend(put(text, named("joint", joint)?, "dynamics", Some(line)));
    }
    edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
    let mut out = text.to_owned();
    for (range, new) in edits {
        out.replace_range(range, &new);
    }
    Ok(out)
}

/// Replaces the first child of a name, takes the others away, or adds one at the end.
fn put(
    text: &str,
    node: Node<'_, '_>,
    name: &str,
    new: Option<String>,
) -> Vec<(Range<usize>, String)> {
    let before = &text[..node.range().start];
    let line = before.rsplit('\n').next().unwrap_or(before);
    let margin: String = line.chars().take_while(|c| *c == ' ' || *c == '\t').collect();
    let lines = new.map(|lines| lines.replace('\n', &format!("\n{margin}  ")));
    let named = node.children().filter(|child| child.has_tag_name(name));
    let old: Vec<Range<usize>> = named.map(|child| child.range()).collect();
    if let Some((first, others)) = old.split_first() {
        let mut edits = vec![(first.clone(), lines.unwrap_or_default())];
        edits.extend(others.iter().map(|range| (range.clone(), String::new())));
        return edits;
    }
    let Some(lines) = lines else { return Vec::new() };
    let range = node.range();
    let whole = &text[range.clone()];
    if whole.ends_with("/>") {
        let end = range.end - 2;
        let tag = node.tag_name().name();
        return vec![(end..range.end, format!(">\n{margin}  {lines}\n{margin}</{tag}>"))];
    }
    // Before the end tag, behind the last element.
    let end = range.start + whole.rfind("</").unwrap_or(whole.len());
    let behind = text[..end].trim_end().len();
    vec![(behind..behind, format!("\n{margin}  {lines}"))]
}

fn inertial(Body { mass, com, inertia: i }: &Body) -> String {
    format!(
        "<inertial>\n  <origin xyz=\"{:?} {:?} {:?}\" rpy=\"0 0 0\"/>\n  <mass value=\"{mass:?}\"/>\n  \
         <inertia ixx=\"{:?}\" ixy=\"{:?}\" ixz=\"{:?}\" iyy=\"{:?}\" iyz=\"{:?}\" izz=\"{:?}\"/>\n\
         </inertial>",
        com.x, com.y, com.z, i.m11, i.m12, i.m13, i.m22, i.m23, i.m33,
    )
}
