// Which of the files that were dropped or chosen together are one volume: the slices of a DICOM series, and a header with
// the file of its samples.

const HEADERS = /\.(nhdr|mhd|hdr)$/i;
const DICOM_MARK = 128; // bytes before "DICM"
const FILES_MOST = 20000;

const promised = (fn) => new Promise(fn);

async function addFiles(out, entry, folder) {
  if (out.length >= FILES_MOST) throw new Error(`more than ${FILES_MOST} files: drop fewer, or use cvol compress`);
  const name = `${folder}${entry.name}`;
  if (entry instanceof File) return void out.push({ name, file: entry });
  if (entry.isFile) return void out.push({ name, file: await promised((...done) => entry.file(...done)) });
  const reader = entry.createReader();
  for (let more; (more = await promised((...done) => reader.readEntries(...done))).length; )
    for (const one of more) if (!one.name.startsWith(".")) await addFiles(out, one, `${name}/`);
}

/** The files of dropped entries, also of folders: [{name: path, file}]. entries: File or FileSystemEntry. */
export async function filesOf(entries) {
  const out = [];
  for (const entry of entries) await addFiles(out, entry, "");
  return out;
}

async function isDicom({ file }) {
  const head = await file.slice(DICOM_MARK, DICOM_MARK + 4).text();
  return head === "DICM" || /\.dcm$/i.test(file.name);
}

const last = (name) => name.split("/").pop();
const single = (one) => ({ name: last(one.name), files: [{ ...one, name: last(one.name) }] });

// The folder in which a converter finds all files, by their first common folder. Names are those of no other file.
function folderOf(files) {
  const [first] = files;
  const folder = files.every(({ name }) => name.split("/")[0] === first.name.split("/")[0]) && first.name.includes("/");
  const name = folder ? first.name.split("/")[0] : last(first.name).replace(/\.[^.]*$/, "");
  return { name, files: files.map((one, i) => ({ ...one, name: `${name}/${i}-${last(one.name)}` })) };
}

/** [{name: of a volume, or of the folder of its files, files: [{name, file}]}, ...] of the files that filesOf() gives. */
export async function volumesOf(files) {
  if (files.length < 2) return files.map(single);
  const header = files.filter(({ name }) => HEADERS.test(name));
  if (header.length === 1)
    return [{ name: last(header[0].name), files: files.map((one) => ({ ...one, name: last(one.name) })) }];
  const are = await Promise.all(files.map(isDicom));
  const slices = files.filter((_, i) => are[i]);
  const others = files.filter((_, i) => !are[i]).map(single);
  // What lies next to the slices of a folder is no volume.
  if (slices.length) return [slices.length > 1 ? folderOf(slices) : single(slices[0]), ...(files[0].name.includes("/") ? [] : others)];
  return others;
}
