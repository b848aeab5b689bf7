// The named transfer functions by application, and named windows.

const PLACES = {
  auto: "Any volume",
  gray: "Any volume",
  bone: "CT",
  "skin-bone": "CT",
  mri: "MRI",
  microscopy: "Microscopy",
  hot: "Microscopy",
  viridis: "Simulation",
  magma: "Simulation",
  "cool-warm": "Simulation",
};
const ORDER = ["Any volume", "CT, Hounsfield units", "CT", "MRI", "Microscopy", "Simulation", "Others"];
const WORDS = { component: "Colour of the file", auto: "Automatic", mri: "MRI", "cool-warm": "Cool to warm", "skin-bone": "Skin and bone" };

export function presetWord(name) {
  const plain = name.replace(/^ct-/, "");
  return WORDS[name] || plain[0].toUpperCase() + plain.slice(1).replaceAll("-", " ");
}

/** [[group, [name, ...]], ...]; those in Hounsfield units only if the volume has these. */
export function presetGroups(about, volume) {
  const groups = new Map(ORDER.map((name) => [name, []]));
  for (const name of about.transfers || [])
    if (!(about.ct_transfers || []).includes(name)) groups.get(PLACES[name] || "Others").push(name);
  if (volume?.channel?.component) groups.get("Any volume").unshift("component");
  if (volume?.rescale) groups.get("CT, Hounsfield units").push(...(about.ct_transfers || []));
  return [...groups].filter(([, names]) => names.length);
}

/** Windows of radiology, [name, level, width] in Hounsfield units. */
export const CT_WINDOWS = [
  ["Soft tissue", 40, 400],
  ["Brain", 40, 80],
  ["Lung", -600, 1500],
  ["Bone", 400, 1800],
];
