#pragma once

namespace relume {

/// The processes that a launcher started for one command.
struct Team {
  int rank = 0;        ///< this process's number, [0, size)
  int size = 1;        ///< processes; 1 = alone
  int local_size = 1;  ///< how many of them run on this machine

  bool is_alone() const { return size == 1; }
};

/// What the launcher says: RELUME_RANK and RELUME_RANKS (any launcher can set them), else Open
/// MPI's variables, else those of PMI (MPICH and others). Alone where none is set. Throws
/// Error(usage) where they make no sense.
Team team_from_environment();

/// The threads of a process of `team` that was told no number: its share of the machine, and no
/// more than the processors that the launcher bound it to.
int share_of_processors(const Team& team);

/// All ranks see the same command line, scene and warnings: rank 0 tells them. The others print
/// nothing on standard output, and on standard error nothing before speak(). Process-wide; does
/// nothing for rank 0.
void listen_only(const Team& team);

/// From here on, what a process has to say is about its own work: standard error is back.
void speak();

}  // namespace relume
