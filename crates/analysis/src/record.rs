//! What is written down: tables, figures, the report, and what a run was made of.
