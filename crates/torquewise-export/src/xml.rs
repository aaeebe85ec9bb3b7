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
    /// A document that begins with a comment.
    pub(crate) fn new(comment: &str) -> Self {
        let mut own = Self { writer: Writer::new_with_indent(Vec::new(), b' ', 2), failed: None };
        own.write(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)));
        own.write(Event::Comment(BytesText::new(&format!(" {comment} "))));
        own
    }

    /// Begins an element.
    pub(crate) fn open(&mut self, name: &str, attributes: &[(&str, &str)]) {
        let element = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.write(Event::Start(element));
    }

    /// Ends it.
    pub(crate) fn close(&mut self, name: &str) {
        self.write(Event::End(BytesEnd::new(name)));
    }

    /// An element with nothing in it.
    pub(crate) fn leaf(&mut self, name: &str, attributes: &[(&str, &str)]) {
        let element = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.write(Event::Empty(element));
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
