"""The paper's protocol: trials of many robots per controller and command."""
