//! What every module is to the board, the simulator or the process that runs it.
