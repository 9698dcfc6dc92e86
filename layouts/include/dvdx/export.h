/* Marks the symbols that a shared library of dvdx exports; all others are hidden. Readable by C. */
#ifndef DVDX_EXPORT_H
#define DVDX_EXPORT_H

#define DVDX_EXPORT __attribute__((visibility("default")))

#endif
