hard_cases! {}
