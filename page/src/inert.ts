/** Makes all of the page inert but one element and STOP; returns what ends that. */
export function besides(element: HTMLElement): () => void {
  const kept = [element, ...document.querySelectorAll("[data-stop]")];
  const made: HTMLElement[] = [];
  const look = (parent: Element): void => {
    for (const child of parent.children) {
      if (kept.includes(child) || !(child instanceof HTMLElement)) continue;
      if (kept.some((each) => child.contains(each))) look(child);
      else if (!child.inert) made.push(child);
    }
  };
  look(document.body);
  for (const each of made) each.inert = true;
  return () => made.forEach((each) => (each.inert = false));
}
