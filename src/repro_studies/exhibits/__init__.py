"""Tables and figures of the studies, which `repro.exhibits.catalogue` finds as an entry point of this package."""

from repro_studies.exhibits import ablation, factorial, study

MODULES = (factorial, ablation, study)
