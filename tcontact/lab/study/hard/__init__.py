"""The hard cases: each module has `cases()`, and `tcontact.lab.study.hard_cases` says what a case is."""
