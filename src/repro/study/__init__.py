"""Where a learned method pays: simulated experiments over motion, unmodelled torque, prior and friction."""
