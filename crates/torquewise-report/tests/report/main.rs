//! Reports, read as text; `python/tests/test_report_page.py` opens them in a real browser.

mod arm;
mod call_cost;
mod friction;
