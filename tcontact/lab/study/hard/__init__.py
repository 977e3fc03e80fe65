"""The hard cases by kind; each module has `cases()`. See `tcontact.lab.study.hard_cases` for what a case is."""
