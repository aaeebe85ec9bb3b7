//! XML, element by element.

use crate::error::ExportError;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

/// A document being written, indented by two spaces.
pub(crate) struct Xml {
    writer: Writer<Vec<u8>>,
    failed: Option<std::io::Error>,
}

impl Xml {
    /// An empty document.
    pub(crate) fn new() -> Self {
        let mut own = Self { writer: Writer::new_with_indent(Vec::new(), b' ', 2), failed: None };
        own.write(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)));
        own
    }

    /// A remark.
    pub(crate) fn comment(&mut self, text: &str) {
        self.write(Event::Comment(BytesText::new(&format!(" {text} "))));
    }

    /// An element that holds text.
    pub(crate) fn text(&mut self, name: &str, attributes: &[(&str, &str)], text: &str) {
        self.open(name, attributes);
        self.write(Event::Text(BytesText::new(text)));
        self.close(name);
    }

    /// Begins an element.
    pub(crate) fn open(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.write(Event::Start(element(name, attributes)));
    }

    /// Ends it.
    pub(crate) fn close(&mut self, name: &str) {
        self.write(Event::End(BytesEnd::new(name)));
    }

    /// An element with nothing in it.
    pub(crate) fn leaf(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.write(Event::Empty(element(name, attributes)));
    }

    fn write(&mut self, event: Event<'_>) {
        if let Err(error) = self.writer.write_event(event) {
            self.failed.get_or_insert(error);
        }
    }

    /// The text.
    ///
    /// # Errors
    /// [`ExportError::Fill`] if an element could not be written.
    pub(crate) fn finish(self) -> Result<String, ExportError> {
        if let Some(error) = self.failed {
            return Err(error.into());
        }
        let mut text = String::from_utf8_lossy(&self.writer.into_inner()).into_owned();
        text.push('\n');
        Ok(text)
    }
}

/// Values are escaped; control characters, which XML cannot hold, become blanks.
fn element<'a>(name: &'a str, attributes: &[(&str, &str)]) -> BytesStart<'a> {
    let mut element = BytesStart::new(name);
    for (key, value) in attributes {
        element.push_attribute((*key, value.replace(char::is_control, " ").as_str()));
    }
    element
}
