rule simulate_tracked:
    output:
        f"{R}/data/tracked.safetensors",
    priority: AWAITED
    params:
        *code("simulate_tracked.py"),
        config=sections("signals", "data", "board", "experiment"),
    message:
        "Simulating the arms whose motions a network is trained on"
    script:
        "../scripts/simulate_tracked.py"


rule mean_torque:
    output:
        f"{R}/data/mean_torque.csv",
    priority: AWAITED
    params:
        *code("mean_torque.py"),
        config=sections("signals", "data", "image", "training"),
    message:
        "Averaging the training torques"
    script:
        "../scripts/mean_torque.py"
