"""What long contacts change, in every report: motion, ends and margin with the membranes' own stiffness."""
