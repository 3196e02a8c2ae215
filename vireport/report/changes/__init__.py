"""What differs between results, as data: quantities in rows, and what has changed since an earlier run."""
