// SPDX-License-Identifier: MIT
// Takes rights away from a process that works on untrusted input with code we do not answer for.
#pragma once

/// From now on this process, for good, can read files in `folder` and below and no others
/// (Landlock, from Linux 5.13 on), cannot write to files, run programs, make processes, send
/// signals to others or use the network (seccomp): such calls fail with an error. Rights that the
/// kernel cannot take away stay. All descriptors but the first three and `kept` are closed. For a
/// child with one thread, after fork(); uses no context.
/// @param folder NULL: no file at all
void stp_sandbox_enter(const char* folder, int kept);
