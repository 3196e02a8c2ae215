"""The paper, whole: its figures, its Table 1 and its printed numbers beside ours, and what others have published."""
