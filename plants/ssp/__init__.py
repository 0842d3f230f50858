"""Systems of FMUs by the standard System Structure and Parameterization (SSP), as experiments."""
