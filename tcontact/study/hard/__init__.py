"""The hard cases by kind; each module has `cases()`. See `tcontact.study.hard_cases` for what a case is."""
