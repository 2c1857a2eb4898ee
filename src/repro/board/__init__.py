"""The FPGA set-up of Section III: wire, controller, simulated board, serial link and captures."""
