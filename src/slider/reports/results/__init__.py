"""Result blocks of the documentation: tables that a command writes from a finished run."""
