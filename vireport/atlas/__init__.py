"""Every family of motions along a sweep: looked for among all flight times, followed, and joined where they meet."""
