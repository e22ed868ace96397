// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace prism {

// Writes a file so that it is either whole or absent: `write` fills a temporary file beside `path`,
// which is then renamed to `path`. The temporary name ends in path's own extension (image encoders
// choose the format by it). If `write` throws or the disk is full the temporary file is removed.
// Links are followed. What stands there and is no regular file (/dev/stdout, a pipe) is written to,
// not replaced. Throws InputError naming `path`.
void WriteFileAtomically(const std::string& path,
                         const std::function<void(const std::string& temporary_path)>& write);

// The same by a stream.
void WriteStreamAtomically(const std::string& path,
                           const std::function<void(std::ostream&)>& write);

// The same for contents in memory.
void WriteTextAtomically(const std::string& path, const std::string& contents);

// The path of a name, or a relative path, in a folder.
std::string InFolder(const std::string& folder, const std::string& name);

// Creates a directory with its parents. Throws InputError if that cannot be done.
void CreateDirectory(const std::string& path);

// Creates it as above and tries whether files can be written to it. Throws InputError if not.
void RequireWritableFolder(const std::string& path);

// Whether there is such a file or folder; of what cannot be looked at (a name too long, a loop of
// links, a folder that may not be read): no.
bool IsFile(const std::string& path);
bool IsFolder(const std::string& path);

// The whole file, without a byte-order mark. Throws InputError if it cannot be read.
std::string ReadTextFile(const std::string& path);

}  // namespace prism
