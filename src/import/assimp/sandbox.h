// SPDX-License-Identifier: MIT
// Removes rights from a process that handles untrusted input with third-party code.
#pragma once

/// From now on, this process can only read files in `folder` and below (Landlock, since Linux
/// 5.13), and cannot write files, run programs, create processes, send signals to others or use the
/// network (seccomp): such calls fail with an error. Rights that the kernel cannot remove remain.
/// Closes all descriptors except the first three and `kept`. For a single-threaded child after
/// fork(); uses no context.
/// @param folder NULL: no file at all
void stp_sandbox_enter(const char* folder, int kept);
