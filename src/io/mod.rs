//! Files to frames, and planes to files.
