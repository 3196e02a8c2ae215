"""How far the rigid model is from compliant membranes: a ladder of stiffnesses, and solvers on the stiff equations."""
